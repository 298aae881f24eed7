// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A program of another dialect in LinuxCNC's language, in a temporary folder of its own that ends with the object. Each
// line stands at its number.

#include <filesystem>

#include "nc/control/control_profile.h"

namespace thermotwin::nc {

class TranslatedProgram {
public:
  /// @param axis_mask  letters of the machine's axes, bit 0: X  @param start  of the axes before it, m and rad
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
