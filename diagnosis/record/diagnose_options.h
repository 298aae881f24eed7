// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a diagnosis is asked for.

#include <string>
#include <vector>

#include "solver/operation/load_program.h"

namespace thermotwin::diagnosis {

struct DiagnoseOptions {
  double heldout_share =
      0.3;  ///< of the time, its end: never fitted, or half of it where the rest leaves the cause open
  /// Mesh and discretisation, of each channel's own response. Temperatures converge faster than displacements, which
  /// add up what every body bends.
  double displacement_error_percent = 3, temperature_error_percent = 1.5;
  double interval_s = 600;                      ///< residuals are averaged over such intervals
  std::vector<solver::LoadProgram> programs{};  ///< that may be run next, where causes share

  void validate() const;  ///< @throws InputError
};

}  // namespace thermotwin::diagnosis
