// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/key_lookup.h"

#include <algorithm>
#include <stdexcept>

#include "core/error.h"
#include "core/text.h"

namespace thermotwin::core {

const Key& required_row(const KeyTable& keys, const std::string& key) {
  const Key* found = keys.find(key);
  if (found == nullptr) throw std::logic_error("no row for key '" + key + "' in the table of " + keys.name);
  return *found;
}

const Key* row_of(const KeyTable* keys, const std::string& key, std::initializer_list<KeyKind> as) {
  if (keys == nullptr) return nullptr;
  const Key& found = required_row(*keys, key);
  if (std::find(as.begin(), as.end(), found.kind) == as.end())
    throw std::logic_error("key '" + key + "' of " + keys->name + " is no " + phrase(*as.begin()));
  return &found;
}

Range range_of(const Key* row, const std::optional<Range>& given) {
  return given ? *given : row != nullptr ? row->range : any_number;
}

std::string much_like(const std::string& key, const std::vector<std::string>& keys) {
  const std::string candidate = nearest(key, keys);
  return edit_distance(key, candidate) <= std::max<std::size_t>(2, key.size() / 3) ? candidate : "";
}

void refuse_key(const std::string& key, const std::string& place, const KeyTable* keys, std::set<std::string> known) {
  if (keys != nullptr && keys->find_exactly(key) != nullptr)
    throw InputError(place, "key '" + key + "' has no meaning here", "leave it out");
  if (keys != nullptr)
    for (const Key& row : keys->keys)
      if (!row.is_pattern()) known.insert(row.name);
  const std::vector<std::string> names(known.begin(), known.end());
  if (names.empty()) throw InputError(place, "unknown key", "no key here");
  throw InputError(place, "unknown key", "nearest is " + nearest(key, names));
}

}  // namespace thermotwin::core
