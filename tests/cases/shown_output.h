// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Compares the output that a page shows with what a command said.

#include <string>
#include <vector>

namespace thermotwin::cases {

/// Lines of a page's block must follow each other in the output, word by word and wrapped in any way; "..." stands for
/// words that are left out. Numbers agree within 3 % or a unit of the last digit that the page shows. Numbers of
/// the computer, those before "s", "min", "rows/s", "MiB" and "GiB", may be any.
/// @return the first shown words that the output does not have; empty: it has all
std::string missing_in(const std::vector<std::string>& shown, const std::string& output);

}  // namespace thermotwin::cases
