// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Temperatures to start from, where a machine is not uniformly warm: the field of another run, on
// whatever mesh, or what a few sensors say.

#include <filesystem>
#include <vector>

#include "core/table.h"
#include "solver/operation/load_program.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// The field that honours the sensors and is nearest to steady: of all T with H T = z the one whose
/// rates E^-1 (f - A T) have the least capacity-weighted square,
///   T = T_s + A^-1 E A^-T H^T w,   (H A^-1 E A^-T H^T) w = z - H T_s,   A T_s = f,
/// A and f those of the operating state c. Smooth (no heat source at a point does that), and the steady field
/// itself where the sensors agree with it. Sensors that repeat each other are averaged.
/// @param sensors  rows of ThermalSystem::sensors   @param values_K  their temperatures above the
/// reference, without the sensors' own offsets
/// @throws SolverError where no body has a path to any ambient
Eigen::VectorXd field_from_sensors(const ThermalSystem& thermal, const Coefficients& c, const std::vector<int>& sensors,
                                   const Eigen::VectorXd& values_K);

/// The same from a table with time_s and <sensor>_C, each sensor taken linearly between its values
/// around the time, in the operating state at the program's start. Columns of no sensor are left out with a warning.
/// @throws InputError: no sensor's column, the time outside the table
Eigen::VectorXd field_from_sensors(const core::Table& table, double time_s, const OperatingModel& model,
                                   const LoadProgram& program, const ThermalSystem& thermal);

/// Fluid nodes := mean temperature of their walls.
void set_fluids_to_walls(const ThermalSystem& thermal, Eigen::VectorXd& temperature);

}  // namespace thermotwin::solver
