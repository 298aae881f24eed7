// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/key_table.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace thermotwin::core {

namespace {

/// "<axis>_mm" is fitted by "X_mm".
bool fits(const std::string& pattern, const std::string& key) {
  const std::size_t open = pattern.find('<'), close = pattern.find('>');
  if (open == std::string::npos || close == std::string::npos) return false;
  const std::string before = pattern.substr(0, open), after = pattern.substr(close + 1);
  return key.size() > before.size() + after.size() && key.starts_with(before) && key.ends_with(after);
}

Key row(std::string name, KeyKind kind, Otherwise otherwise, std::string says) {
  Key key;
  key.name = std::move(name);
  key.kind = kind;
  key.otherwise = std::move(otherwise);
  key.says = std::move(says);
  return key;
}

Key quantity(std::string name, KeyKind kind, std::string unit, Range range, Otherwise otherwise, std::string says) {
  Key key = row(std::move(name), kind, std::move(otherwise), std::move(says));
  key.unit = std::move(unit);
  key.range = range;
  return key;
}

Key section(std::string name, KeyKind kind, const KeyTable& keys, Otherwise otherwise, std::string says) {
  Key key = row(std::move(name), kind, std::move(otherwise), std::move(says));
  key.keys = &keys;
  return key;
}

}  // namespace

std::string phrase(KeyKind kind) {
  switch (kind) {
    case KeyKind::text: return "text";
    case KeyKind::reference: return "id";
    case KeyKind::word: return "word";
    case KeyKind::number: return "number";
    case KeyKind::uncertain: return "number *u*";
    case KeyKind::whole: return "whole number";
    case KeyKind::flag: return "true or false";
    case KeyKind::point: return "[x, y, z]";
    case KeyKind::numbers: return "numbers";
    case KeyKind::texts: return "texts";
    case KeyKind::points: return "points";
    case KeyKind::table: return "table";
    case KeyKind::tables: return "tables";
  }
  return "";
}

Key Key::or_list() const {
  Key key = *this;
  key.list = true;
  return key;
}

const Key* KeyTable::find_exactly(const std::string& wanted) const {
  const auto at = std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.name == wanted; });
  return at == keys.end() ? nullptr : &*at;
}

const Key* KeyTable::find(const std::string& wanted) const {
  if (const Key* exact = find_exactly(wanted)) return exact;
  const auto at = std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return fits(key.name, wanted); });
  return at == keys.end() ? nullptr : &*at;
}

namespace key {

Key text(std::string name, Otherwise otherwise, std::string says) {
  return row(std::move(name), KeyKind::text, std::move(otherwise), std::move(says));
}

Key reference(std::string name, std::string to, Otherwise otherwise, std::string says) {
  Key key = row(std::move(name), KeyKind::reference, std::move(otherwise), std::move(says));
  key.words = {std::move(to)};
  return key;
}

Key word(std::string name, std::vector<std::string> words, Otherwise otherwise, std::string says) {
  Key key = row(std::move(name), KeyKind::word, std::move(otherwise), std::move(says));
  key.words = std::move(words);
  return key;
}

Key number(std::string name, std::string unit, Range range, Otherwise otherwise, std::string says) {
  return quantity(std::move(name), KeyKind::number, std::move(unit), range, std::move(otherwise), std::move(says));
}

Key uncertain(std::string name, std::string unit, Range range, Otherwise otherwise, std::string says) {
  return quantity(std::move(name), KeyKind::uncertain, std::move(unit), range, std::move(otherwise), std::move(says));
}

Key whole(std::string name, int low, int high, Otherwise otherwise, std::string says) {
  return quantity(std::move(name), KeyKind::whole, "", {1.0 * low, 1.0 * high}, std::move(otherwise), std::move(says));
}

Key flag(std::string name, Otherwise otherwise, std::string says) {
  return row(std::move(name), KeyKind::flag, std::move(otherwise), std::move(says));
}

Key point(std::string name, std::string unit, Otherwise otherwise, std::string says) {
  return quantity(std::move(name), KeyKind::point, std::move(unit), any_number, std::move(otherwise), std::move(says));
}

Key numbers(std::string name, std::string unit, Range range, Otherwise otherwise, std::string says) {
  return quantity(std::move(name), KeyKind::numbers, std::move(unit), range, std::move(otherwise), std::move(says));
}

Key texts(std::string name, Otherwise otherwise, std::string says) {
  return row(std::move(name), KeyKind::texts, std::move(otherwise), std::move(says));
}

Key points(std::string name, std::string unit, Otherwise otherwise, std::string says) {
  return quantity(std::move(name), KeyKind::points, std::move(unit), any_number, std::move(otherwise), std::move(says));
}

Key table(std::string name, const KeyTable& keys, Otherwise otherwise, std::string says) {
  return section(std::move(name), KeyKind::table, keys, std::move(otherwise), std::move(says));
}

Key tables(std::string name, const KeyTable& keys, Otherwise otherwise, std::string says) {
  return section(std::move(name), KeyKind::tables, keys, std::move(otherwise), std::move(says));
}

Key schema(Otherwise otherwise) {
  return whole("schema", 1, std::numeric_limits<int>::max(), std::move(otherwise),
               "Version of the file's keys; a newer one than the program reads is refused.");
}

}  // namespace key

}  // namespace thermotwin::core
