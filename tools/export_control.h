// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// `export MODEL --c`, `--fmu` and `--linuxcnc`: a reduced model as C source for a control, as an FMU, or with what
// joins it to a LinuxCNC configuration.

#include "tools/options.h"

namespace thermotwin::tools {

struct ControlExportOptions : ExportOptions {
  std::filesystem::path c_folder;  ///< empty: no C source
  int fmu = 0;                     ///< version of FMI, 2 or 3; 0: no FMU
  std::filesystem::path linuxcnc;  ///< INI file of a LinuxCNC configuration; empty: nothing for LinuxCNC
  double step_s = 60;              ///< longest step of the state
  double start_C = 20;
  double largest_um = 0, rate_um_s = 0;  ///< 0: by the model
  double tolerance = 1e-7;
  int order = 0;            ///< of the model; 0: its own
  bool observer = true;     ///< sensors correct the model
  double start_over_s = 0;  ///< the work of the start is spread over this time
};

/// Writes the C source, the FMU or the folder for LinuxCNC, or does what export_model() does.
void export_any(const ControlExportOptions& options);

}  // namespace thermotwin::tools
