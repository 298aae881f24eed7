// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// `nc`: time, loads, error and rewriting along an NC program.

#include <filesystem>
#include <string>

#include "tools/options.h"

namespace thermotwin::tools {

struct NcOptions : CommonOptions {
  std::filesystem::path model;  ///< model.rom.h5, a case folder or machine.toml
  std::filesystem::path program;
  std::string control = "linuxcnc";
  std::filesystem::path tools, folder;
  std::string start;  ///< pose before the program; empty: home
  double start_C = 20, row_s = 10;
  std::string rewrite;  ///< empty, "path" or "shift"
  double tolerance_um = 0.5;
  bool no_blocks = false;
  int repeat = 1;      ///< runs of the program
  double pause_s = 0;  ///< between them
};

void nc(const NcOptions& options);

}  // namespace thermotwin::tools
