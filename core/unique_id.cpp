// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/unique_id.h"

#include <algorithm>

#include "core/character.h"
#include "core/error.h"

namespace thermotwin::core {

void require_unique_id(const std::string& id, const std::string& place, std::vector<std::string>& seen) {
  const bool well_formed = !id.empty() && std::all_of(id.begin(), id.end(), [](char c) {
    return is_letter_or_digit(c) || c == '_' || c == '.' || c == '-';
  });
  if (!well_formed) throw InputError(place, "id \"" + id + "\"", "letters, digits and _ . - in an id");
  if (std::find(seen.begin(), seen.end(), id) != seen.end()) {
    throw InputError(place, "id \"" + id + "\" a second time", "each id once");
  }
  seen.push_back(id);
}

}  // namespace thermotwin::core
