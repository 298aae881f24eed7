// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The ids of a file's tables.

#include <string>
#include <vector>

namespace thermotwin::core {

/// @throws InputError if two ids are equal or one is empty; ids may hold letters, digits, _ . -
void require_unique_id(const std::string& id, const std::string& place, std::vector<std::string>& seen);

}  // namespace thermotwin::core
