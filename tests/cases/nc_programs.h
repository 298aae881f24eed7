// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the tests of `nc` share.

#include <string>

namespace thermotwin::cases {

/// Whether the helper with LinuxCNC's interpreter lies beside the program. With THERMOTWIN_LINUXCNC set it must.
bool has_interpreter();

/// rows.csv names its machine in a line before the header.
std::string after_first_line(const std::string& text);

}  // namespace thermotwin::cases
