// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs an NC program through LinuxCNC's interpreter, in the helper process thermotwin_rs274. The helper has no
// environment, writes no file, reads files below the program's folder only, and ends at its limits. It is killed where
// it says nothing for longer than its processor time allows.

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "nc/control/control_profile.h"
#include "nc/rs274/records.h"

namespace thermotwin::nc {

struct Record {
  rs274::Kind kind;
  int index = 0;
  std::uint32_t line = 0;
  std::array<double, 16> values{};  ///< of the kind, see records.h
  std::string_view text;            ///< valid during the call
};

struct InterpreterOptions {
  std::filesystem::path program;
  std::filesystem::path folder;  ///< of subprograms; empty: the program's own
  std::filesystem::path helper;  ///< empty: where the build or the installation has it
  Nine start = Nine::Zero();     ///< position of the axes before the program, m and rad
  int axis_mask = 0x7;           ///< bit 0: X
  bool open_end = true;          ///< the program may end without M2, M30 or %
};

/// @return the helper's path; empty: the program was built without LinuxCNC's interpreter
std::filesystem::path find_helper();

/// A program in another dialect than LinuxCNC's runs as its translation; records have its own name and lines.
/// @param take  receives the records in their order
/// @return lines of the program that begin with /
/// @throws InputError (file:line) for a program that the interpreter or the profile refuses, or that does not end
long interpret(const InterpreterOptions& options, const ControlProfile& control,
               const std::function<void(const Record&)>& take);

}  // namespace thermotwin::nc
