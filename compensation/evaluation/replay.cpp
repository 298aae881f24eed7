// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/replay.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "compensation/measurement/dataset.h"
#include "compensation/measurement/measurement_check.h"
#include "compensation/online/axis_reach.h"
#include "compensation/online/offset_guard.h"
#include "compensation/online/output_map.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double start_temperature(const Measurement& measurement, const mesh::Machine& machine, Index from) {
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.input != "air.T_C") continue;
    const VectorXd values = measurement.values(channel).tail(measurement.data.rows() - from);
    if (const Index first = known_range(values).first; first >= 0) return values[first];
  }
  return machine.reference_C;
}

MatrixXd compensator_rows(const Measurement& measurement, const mesh::Machine& machine,
                          const solver::Channels& channels, const MeasuredRun& how) {
  const MatrixXd held = channel_rows(measurement, channels);
  // Row i of a measurement holds until i + 1; the compensator is told what held since its last row.
  MatrixXd rows = held;
  if (held.rows() > 1) rows.bottomRows(held.rows() - 1) = held.topRows(held.rows() - 1);
  if (!how.told_surroundings) return rows;
  const double air_C = start_temperature(measurement, machine, how.from);
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    const std::string name = ambient.id + ".T_C";
    const bool measured = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                      [&](const MeasuredChannel& c) { return c.input == name; });
    // What is warmer than the reference at home (a fluid in its tank) is so above this hall too.
    if (!measured && ambient.follows.empty())
      rows.col(channels.index(name)).setConstant(air_C + ambient.default_C.value - machine.reference_C);
  }
  return rows;
}

/// Channels with a default that nobody measured.
std::vector<Index> unmeasured_inputs(const Measurement& measurement, const solver::Channels& channels) {
  std::vector<Index> absent;
  for (Index k = 0; k < channels.size(); ++k) {
    const std::string& name = channels.names()[k];
    if (!std::isnan(channels.defaults()[k]) &&
        std::none_of(measurement.channels.begin(), measurement.channels.end(),
                     [&](const MeasuredChannel& c) { return c.input == name; })) {
      absent.push_back(k);
    }
  }
  return absent;
}

MatrixXd sensor_readings(const Measurement& measurement, const mesh::Machine& machine) {
  MatrixXd readings = MatrixXd::Constant(measurement.data.rows(), std::ssize(machine.sensors), solver::not_given);
  for (const MeasuredChannel& channel : measurement.channels) {
    if (const int sensor = machine.sensor_index(channel.sensor); sensor >= 0)
      readings.col(sensor) = measurement.values(channel);
  }
  return readings;
}

std::vector<std::vector<solver::TcpError>> run_compensator(const Measurement& measurement,
                                                           const reduction::ReducedModel& model,
                                                           const std::vector<mesh::Pose>& poses, const MeasuredRun& how,
                                                           std::string* explained, std::vector<std::string>* failed,
                                                           std::vector<Eigen::Matrix3Xd>* std_um) {
  CompensatorOptions options;
  options.use_sensors = options.start_from_sensors = how.sensors;
  const solver::Channels channels(model.machine);
  const MatrixXd rows = compensator_rows(measurement, model.machine, channels, how);
  const MatrixXd readings = sensor_readings(measurement, model.machine);
  const VectorXd time = measurement.time();
  std::vector<std::vector<solver::TcpError>> errors(poses.size());
  const std::vector<Index> absent = unmeasured_inputs(measurement, channels);
  std::optional<Compensator> compensator;
  std::vector<OffsetGuard> guards;
  const OutputMap map(model);
  std::vector<AxisReach> reaches;
  for (const mesh::Pose& pose : poses) reaches.emplace_back(model.machine, pose);
  if (std_um != nullptr) std_um->assign(poses.size(), Eigen::Matrix3Xd::Zero(3, time.size() - how.from));
  for (Index i = how.from; i < time.size(); ++i) {
    const bool gap = compensator && time[i] - time[i - 1] > how.longest_gap_s;
    if (!compensator || gap) {
      options.start_C = start_temperature(measurement, model.machine, i);
      compensator.emplace(model, options);
      compensator->never_told(absent);
      GuardOptions limits;
      limits.largest_um = compensator->limits().largest_um;
      limits.rate_um_s = compensator->limits().rate_um_s;
      guards.assign(poses.size(), OffsetGuard(std::ssize(compensator->axes()), limits));
    }
    // What held before a gap says nothing any more.
    const Index told = gap ? std::min(i + 1, time.size() - 1) : i;
    const Offsets& offsets = compensator->step(time[i], rows.row(told).transpose(),
                                               how.sensors ? VectorXd(readings.row(i).transpose()) : VectorXd());
    if (failed != nullptr) failed->push_back(offsets.failed_sensors);
    for (std::size_t p = 0; p < poses.size(); ++p) {
      solver::TcpError error = compensator->tcp(poses[p]);
      const VectorXd wanted_um = how.guarded ? VectorXd(map.offsets(error) / core::units::um) : VectorXd();
      VectorXd back_um = VectorXd::Zero(std::ssize(map.axes()));
      if (how.guarded) {
        const VectorXd& applied_um = guards[p].step(time[i], wanted_um);
        back_um = applied_um - wanted_um;
        error.error.head<3>() = -reaches[p].motion(applied_um * core::units::um);
      }
      if (std_um != nullptr) {
        const VectorXd own_um = compensator->std_um(poses[p]);
        for (Index a = 0; a < own_um.size(); ++a) {
          const VectorXd alone = VectorXd::Unit(own_um.size(), a) * std::hypot(own_um[a], back_um[a]);
          (*std_um)[p].col(i - how.from) += reaches[p].motion(alone).cwiseAbs2();
        }
      }
      errors[p].push_back(error);
    }
  }
  if (std_um != nullptr)
    for (Eigen::Matrix3Xd& deviations : *std_um) deviations = deviations.cwiseSqrt().eval();
  if (explained != nullptr && time.size() - how.from > 1) *explained = compensator->detectability().brief();
  return errors;
}

}  // namespace thermotwin::compensation
