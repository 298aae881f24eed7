// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/nc_programs.h"

#include <cstdlib>
#include <filesystem>

namespace thermotwin::cases {

bool has_interpreter() {
  return std::getenv("THERMOTWIN_LINUXCNC") != nullptr ||
         std::filesystem::exists(std::filesystem::path(THERMOTWIN_PROGRAM).parent_path() / "thermotwin_rs274");
}

std::string after_first_line(const std::string& text) { return text.substr(text.find('\n') + 1); }

}  // namespace thermotwin::cases
