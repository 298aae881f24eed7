// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Keys of a file beside the rows of its KeyTable: the row that a key is read by, what it says of an absent key, and why
// a key is refused.

#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "core/key_table.h"
#include "core/range.h"

namespace thermotwin::core {

/// @throws std::logic_error  if the table has no row for the key
const Key& required_row(const KeyTable& keys, const std::string& key);

/// @return the row of a key that is read as one of these kinds; nullptr in a file without a KeyTable
/// @throws std::logic_error  for a key without a row, or of another kind
const Key* row_of(const KeyTable* keys, const std::string& key, std::initializer_list<KeyKind> as);

/// The value of an absent key, if its row has one of this type.
template <class T>
const T* value_of(const Key* row) {
  return row == nullptr ? nullptr : std::get_if<T>(&row->otherwise);
}

/// @param given  applies instead of the row's
Range range_of(const Key* row, const std::optional<Range>& given);

/// @return the key that reads much like the given one; empty if none does
std::string much_like(const std::string& key, const std::vector<std::string>& keys);

/// @param keys  nullptr: none  @param known  keys that were asked for
/// @throws InputError (place) always: the key is an unknown one, with the nearest known key, or one that has no meaning
///   beside the others
[[noreturn]] void refuse_key(const std::string& key, const std::string& place, const KeyTable* keys,
                             std::set<std::string> known);

}  // namespace thermotwin::core
