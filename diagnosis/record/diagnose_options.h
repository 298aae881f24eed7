// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a diagnosis is asked for.

#include <optional>
#include <string>
#include <vector>

#include "solver/operation/load_program.h"

namespace thermotwin::diagnosis {

/// Without an estimate. Temperatures converge faster than displacements, which add up what every body bends.
inline constexpr double assumed_displacement_error_percent = 3, assumed_temperature_error_percent = 1.5;

struct DiagnoseOptions {
  double heldout_share =
      0.3;  ///< of the time, its end: never fitted, or half of it where the rest leaves the cause open
  /// Mesh and discretisation, of each channel's own response. Absent: what the model file states of each channel
  /// (reduction::MeshError), or the assumed values above.
  std::optional<double> displacement_error_percent{}, temperature_error_percent{};
  double interval_s = 600;                      ///< residuals are averaged over such intervals
  std::vector<solver::LoadProgram> programs{};  ///< that may be run next, where causes share

  void validate() const;  ///< @throws InputError
};

}  // namespace thermotwin::diagnosis
