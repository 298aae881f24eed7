// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The compensator beside a machine that was measured: row after row of a measurement, as a control
// would send them, and the TCP error that it predicts at poses, the model's own prediction. Guarded, the translations
// are what the offsets cancel instead: offsets of limited size and rate, which at the first row are nought, moved
// through the linear axes. An error in a direction that no linear axis moves is predicted, but not cancelled.

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "compensation/online/compensator.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

struct MeasuredRun {
  bool sensors = true;
  /// Ambients that nobody measures stand where the air stood at the start: what an operator who knows
  /// the hall would say; without it they stand at their defaults.
  bool told_surroundings = false;
  Eigen::Index from = 0;  ///< row of the start: what came before is unknown
  bool guarded = false;   ///< translations that the guarded offsets cancel, instead of the predicted ones
  double longest_gap_s = 12 * core::units::hour;  ///< after a longer one nobody knows what the machine did: a new start
};

/// Inputs row by row as a compensator wants them: what held since the row before. (rows x channels)
Eigen::MatrixXd compensator_rows(const Measurement& measurement, const mesh::Machine& machine,
                                 const solver::Channels& channels, const MeasuredRun& how);
/// Readings of the machine's sensors, (rows x sensors), NaN where missing or not measured.
Eigen::MatrixXd sensor_readings(const Measurement& measurement, const mesh::Machine& machine);
/// Uniform start where no sensor tells better: the first air temperature, else the reference.
double start_temperature(const Measurement& measurement, const mesh::Machine& machine, Eigen::Index from = 0);

/// @param explained  if given: gets what the observer's sensors could tell (Detectability::brief)
/// @param failed     if given: gets Offsets::failed_sensors of each row from `from` on
/// @param std_um     if given: gets one standard deviation of what the offsets cancel, (3 x rows) of each pose, with
///   what the guard keeps back; nought in directions that no linear axis moves
/// @return for each pose, as if the machine stood there, the predicted errors at the rows from `from` on
std::vector<std::vector<solver::TcpError>> run_compensator(const Measurement& measurement,
                                                           const reduction::ReducedModel& model,
                                                           const std::vector<mesh::Pose>& poses, const MeasuredRun& how,
                                                           std::string* explained = nullptr,
                                                           std::vector<std::string>* failed = nullptr,
                                                           std::vector<Eigen::Matrix3Xd>* std_um = nullptr);

}  // namespace thermotwin::compensation
