// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Ten hours of a day's work on the lumped machine, and the truth of a machine that is not nominal.

#include <algorithm>
#include <cmath>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation::test {

/// Channels from time - step to time.
inline Eigen::VectorXd shift_row(const solver::Channels& channels, double time) {
  Eigen::VectorXd row = channels.defaults();
  const auto set = [&](const char* name, double value) { row[channels.index(name)] = value; };
  const double h = time / 3600.0;
  set("air.T_C", 20.0 + 3.0 * std::clamp((h - 3.0) / 4.0, 0.0, 1.0));
  if (h <= 3.0) set("spindle.speed_rpm", 6000);
  if (h > 5.0 && h <= 7.0) set("spindle.speed_rpm", 11000);
  const bool moves = h > 2.0 && h <= 6.0;
  set("axis.X.feed_mm_min", moves ? 20000 : 0);
  // A range that is not given would keep its last value: an axis that stands says so.
  set("axis.X.low_mm", moves ? -300 : 0);
  set("axis.X.high_mm", moves ? 300 : 0);
  if (h > 4.0 && h <= 8.0) set("axis.C.feed_deg_min", 54000);
  if (h > 6.0 && h <= 9.0) set("cutting_fluid.on", 1);
  return row;
}

/// A machine run through the shift: its state, sensors (readings) and errors at poses.
struct Truth {
  std::vector<double> time;
  std::vector<Eigen::VectorXd> rows;  ///< that held since the last time
  std::vector<Eigen::VectorXd> readings_C;
  std::vector<std::vector<solver::TcpError>> errors;
};

/// @param machine  parameters of the truth; @param system, outputs  of the truth
inline Truth run_truth(const mesh::Machine& machine, const reduction::ReducedModel& structure, double step,
                       int rows_every, double duration, const std::vector<mesh::Pose>& poses, double start_C = 20.0) {
  reduction::ReducedStepper stepper(structure.system);
  const solver::OperatingModel operating(machine, structure.system.layout);
  Eigen::VectorXd state = stepper.uniform(start_C - machine.reference_C);
  const auto readings_K = [&] { return Eigen::VectorXd(structure.system.sensors * state); };
  Eigen::VectorXd row = shift_row(operating.channels(), 0.5 * step);
  solver::Chiller chiller(
      machine, operating.layout(), operating.channels(),
      solver::chiller_set_points(machine, operating.layout(), readings_K(), operating.guide_K(row)));
  Truth truth;
  const auto record = [&](double time) {
    truth.time.push_back(time);
    truth.rows.push_back(row);
    truth.readings_C.push_back(readings_K().array() + machine.reference_C);
    std::vector<solver::TcpError> at;
    for (const mesh::Pose& pose : poses) at.push_back(structure.tcp(state, pose));
    truth.errors.push_back(std::move(at));
  };
  record(0.0);
  const long steps = std::lround(duration / step);
  for (long i = 1; i <= steps; ++i) {
    row = shift_row(operating.channels(), (i - 0.5) * step);
    const Eigen::VectorXd outlet = chiller.advance(row, readings_K(), operating.guide_K(row), step);
    stepper.advance(state, operating.coefficients(row, outlet), step);
    if (i % rows_every == 0) record(static_cast<double>(i) * step);
  }
  return truth;
}

}  // namespace thermotwin::compensation::test
