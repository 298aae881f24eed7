// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Describes the keys of a file: their types, ranges, defaults and meaning. A Config that is bound to such a table takes
// ranges, defaults and words from it, and the reference documentation is generated from it.

#include <string>
#include <variant>
#include <vector>

#include "core/range.h"

namespace thermotwin::core {

struct KeyTable;

enum class KeyKind {
  text,
  reference,  ///< the id of another table
  word,       ///< one of several
  number,
  uncertain,  ///< 5.0 or {value = 5.0, std_percent = 10}
  whole,      ///< a whole number
  flag,       ///< true or false
  point,      ///< three numbers
  numbers,
  texts,  ///< a text or an array of texts
  points,
  table,
  tables
};

/// @return the type as the documentation names it: "number", "true or false", ...
std::string phrase(KeyKind kind);

struct Required {};
inline constexpr Required required{};
/// An absent key is a state of its own. @param says  its meaning, e.g. "stands on the ground"; may be empty
struct Absent {
  std::string says;
};

struct Key {
  std::string name;  ///< "density_kg_m3"; "<axis>_mm": one for each axis
  KeyKind kind = KeyKind::text;
  std::string unit;  ///< "kg/m3"; empty where there is none
  Range range = any_number;
  std::variant<Required, Absent, double, bool, std::string> otherwise;  ///< meaning of an absent key
  std::vector<std::string> words;  ///< allowed words; of a reference: the tables it may refer to
  const KeyTable* keys = nullptr;  ///< of a table or tables
  std::string says;                ///< one sentence
  bool list = false;               ///< an array of numbers is allowed as well

  /// @return the same key that also allows an array of numbers
  Key or_list() const;
  bool is_pattern() const { return name.find('<') != std::string::npos; }
};

using Otherwise = decltype(Key::otherwise);

struct KeyTable {
  std::string name;  ///< "machine.toml", "material", "volume.exchange"
  std::string says;  ///< one sentence
  std::vector<Key> keys;

  /// The row of a key: that of its name, else the first whose pattern it fits. nullptr: there is none
  const Key* find(const std::string& key) const;
  /// The row of exactly this name. nullptr: there is none
  const Key* find_exactly(const std::string& name) const;
};

/// Make rows of a KeyTable. The last argument states the meaning of the key in one sentence.
namespace key {

Key text(std::string name, Otherwise otherwise, std::string says);
/// @param to  "material", "ambient or volume"
Key reference(std::string name, std::string to, Otherwise otherwise, std::string says);
Key word(std::string name, std::vector<std::string> words, Otherwise otherwise, std::string says);
Key number(std::string name, std::string unit, Range range, Otherwise otherwise, std::string says);
Key uncertain(std::string name, std::string unit, Range range, Otherwise otherwise, std::string says);
Key whole(std::string name, int low, int high, Otherwise otherwise, std::string says);
Key flag(std::string name, Otherwise otherwise, std::string says);
Key point(std::string name, std::string unit, Otherwise otherwise, std::string says);
Key numbers(std::string name, std::string unit, Range range, Otherwise otherwise, std::string says);
Key texts(std::string name, Otherwise otherwise, std::string says);
Key points(std::string name, std::string unit, Otherwise otherwise, std::string says);
Key table(std::string name, const KeyTable& keys, Otherwise otherwise, std::string says);
Key tables(std::string name, const KeyTable& keys, Otherwise otherwise, std::string says);
/// schema = 1
Key schema(Otherwise otherwise = required);

}  // namespace key

}  // namespace thermotwin::core
