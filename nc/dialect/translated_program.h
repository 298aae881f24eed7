// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// An NC program of another dialect, translated into LinuxCNC's language. The file lies in a temporary folder of its
// own, which the destructor removes. Each line keeps its number.

#include <filesystem>

#include "nc/control/control_profile.h"

namespace thermotwin::nc {

class TranslatedProgram {
public:
  /// @param axis_mask  letters of the machine's axes, bit 0: X
  /// @param start  axis positions before the program, m and rad
  /// @throws InputError (file:line) where the dialect's reader refuses the program
  TranslatedProgram(const std::filesystem::path& program, const ControlProfile& control, int axis_mask,
                    const Nine& start);
  ~TranslatedProgram();
  TranslatedProgram(const TranslatedProgram&) = delete;
  TranslatedProgram& operator=(const TranslatedProgram&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path path() const { return folder_ / "program.ngc"; }

private:
  std::filesystem::path folder_;
};

}  // namespace thermotwin::nc
