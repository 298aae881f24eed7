// SPDX-License-Identifier: GPL-3.0-or-later
// The reduced model of the machine on a measurement, with and without sensors.

#include "compensation/evaluation/reduced_models.h"

#include <fmt/format.h>

#include <iterator>

#include "compensation/evaluation/replay.h"
#include "compensation/evaluation/scoring.h"
#include "compensation/measurement/measurement_check.h"
#include "core/error.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Errors in the frame of the table where the channel asks for it.
void turn_into_frame(std::vector<solver::TcpError>& errors, const MeasuredChannel& channel,
                     const mesh::Machine& machine, const mesh::Pose& pose) {
  if (channel.frame != "table") return;
  const Eigen::Matrix3d to_table =
      mesh::body_transform(machine, machine.body_index(machine.tcp.table_body), pose).linear().transpose();
  for (solver::TcpError& error : errors) {
    for (solver::Vector6* part : {&error.error, &error.tool, &error.table}) {
      part->head<3>() = (to_table * part->head<3>()).eval();
      part->tail<3>() = (to_table * part->tail<3>()).eval();
    }
  }
}

}  // namespace

void score_reduced_model(const Measurement& measurement, const reduction::ReducedModel& model, const std::string& name,
                         bool with_sensors, Scorer& scorer) {
  require_fits(measurement, model.machine);
  const std::vector<MeasuredChannel>& displacements = scorer.data().targets;
  std::vector<mesh::Pose> poses;
  for (const MeasuredChannel& channel : displacements) {
    poses.push_back(mesh::parse_pose(model.machine, channel.pose_text, channel.id));
  }
  std::vector<std::vector<solver::TcpError>> errors =
      run_compensator(measurement, model, poses, {with_sensors, false, 0}, with_sensors ? &scorer.observer : nullptr);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const MeasuredChannel& channel = displacements[k];
    turn_into_frame(errors[k], channel, model.machine, poses[k]);
    const VectorXd predicted = quantity_series(errors[k], channel);
    scorer.add(with_sensors ? name + "_sensors" : name, k, predicted, false);
  }
  if (!with_sensors) {
    scorer.note(fmt::format("{}: not fitted; initial temperature uniform at {:.2f} degC", name,
                            start_temperature(measurement, model.machine)));
  }
}

VectorXd quantity_series(const std::vector<solver::TcpError>& errors, const MeasuredChannel& channel) {
  static constexpr const char* direct[] = {"dx", "dy", "dz", "ra", "rb", "rc"};
  static constexpr char iso[] = {'X', 'Y', 'Z', 'A', 'B', 'C'};
  const std::string& quantity = channel.quantity;
  int component = -1;
  double sign = 1.0;
  for (int i = 0; i < 6; ++i) {
    if (quantity == direct[i]) component = i;
    // An ISO location error is where the axis (or the table) went; the TCP error is tool - table.
    if (quantity.size() == 3 && quantity[1] == '0' && quantity[0] == iso[i]) {
      component = i;
      sign = -1.0;
    }
  }
  if (component < 0) {
    throw core::InputError("channel '" + channel.id + "'", "quantity '" + quantity + "'",
                           "a displacement or rotation of the TCP at a pose: dx dy dz ra rb rc X0C Y0C Z0T A0C B0C");
  }
  const double scale = sign / (component < 3 ? core::units::um : core::units::um_per_m);
  VectorXd values(std::ssize(errors));
  for (Index i = 0; i < values.size(); ++i) values[i] = scale * errors[i].error[component];
  return values;
}

}  // namespace thermotwin::compensation
