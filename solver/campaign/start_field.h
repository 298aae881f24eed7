// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Initial temperature fields of a machine that is not uniformly warm, from the readings of a few sensors.

#include <filesystem>
#include <vector>

#include "core/table.h"
#include "solver/operation/load_program.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// The field that agrees with the sensors and is closest to steady state: of all T with H T = z, the one whose rates
/// E^-1 (f - A T) have the least capacity-weighted square,
///   T = T_s + A^-1 E A^-T H^T w,   (H A^-1 E A^-T H^T) w = z - H T_s,   A T_s = f,
/// with A and f of the operating state c. The field is smooth, and it is the steady field T_s if the sensors agree with
/// that. Redundant sensors are averaged.
/// @param sensors  rows of ThermalSystem::sensors   @param values_K  their temperatures above the
/// reference, without the sensors' own offsets
/// @throws SolverError if no body has a path to any ambient
Eigen::VectorXd field_from_sensors(const ThermalSystem& thermal, const Coefficients& c, const std::vector<int>& sensors,
                                   const Eigen::VectorXd& values_K);

/// The same field from a table with time_s and `<sensor>_C`, for the operating state at the start of the program. Each
/// sensor is interpolated linearly between its values around the time. Other columns are left out with a warning.
/// @throws InputError if no column belongs to a sensor, or the time lies outside the table
Eigen::VectorXd field_from_sensors(const core::Table& table, double time_s, const OperatingModel& model,
                                   const LoadProgram& program, const ThermalSystem& thermal);

/// Sets the fluid nodes to the mean temperature of their walls.
void set_fluids_to_walls(const ThermalSystem& thermal, Eigen::VectorXd& temperature);

}  // namespace thermotwin::solver
