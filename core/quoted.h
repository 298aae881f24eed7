// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Text in quotes, for a shell and for a cell of a CSV file.

#include <string>

namespace thermotwin::core {

/// One word of a POSIX shell; plain text stays as it is.
std::string shell_word(const std::string& text);

/// A cell that may hold commas; a double quote in it becomes a single one.
std::string csv_cell(std::string text);

}  // namespace thermotwin::core
