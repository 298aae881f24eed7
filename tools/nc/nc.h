// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// `nc`: time, loads, error and rewriting along an NC program.

#include <filesystem>
#include <optional>
#include <string>

#include "tools/options.h"

namespace thermotwin::tools {

struct NcOptions : CommonOptions {
  std::filesystem::path model;  ///< model.rom.h5, a case folder or machine.toml
  std::filesystem::path program;
  std::string control = "linuxcnc";
  std::filesystem::path tools, folder;
  std::filesystem::path log;      ///< of a control: times of lines; empty: the planner's
  std::filesystem::path process;  ///< heat of the cutting process; empty: none
  std::string start;              ///< pose before the program; empty: home
  double start_C = 20, row_s = 10;
  bool rested = false;                   ///< no heat of earlier work is left in the machine
  std::filesystem::path state;           ///< of `compensate --state`; empty: at start_C
  std::optional<double> after_s;         ///< from the state to the program; none: row_s
  double step_s = 60;                    ///< of `compensate` that saved the state, as those below
  double largest_um = 0, rate_um_s = 0;  ///< 0: by the model
  int order = 0;                         ///< of the model; 0: its own
  std::string rewrite;                   ///< empty, "path" or "shift"
  double tolerance_um = 0.5;
  bool no_blocks = false, no_page = false;
  std::optional<int> imprint;  ///< tool of the finishing pass; none: no imprint
  int repeat = 1;              ///< runs of the program
  double pause_s = 0;          ///< between them
  double time_factor = 1;      ///< on the planner's times
};

void nc(const NcOptions& options);

}  // namespace thermotwin::tools
