// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/signals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace thermotwin::metrology {

namespace units = core::units;
using core::Table;
using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

std::vector<std::string> probe_columns(Index probes) {
  std::vector<std::string> names;
  for (Index i = 0; i < probes; ++i) names.push_back(fmt::format("P{}_um", i + 1));
  return names;
}

/// Centre and both ends of each axis, always reached from the same side (Gebhardt 2014, 4.1.2).
Table calibration_table(const ProbeSetup& setup, core::NormalDraws& normal) {
  Table table;
  table.source = "calibration.csv";
  table.columns = {"x_mm", "y_mm", "z_mm"};
  const Index probes = setup.directions.cols();
  for (const std::string& name : probe_columns(probes)) table.columns.push_back(name);
  table.values.resize(7, 3 + probes);
  const double averaged = setup.record > 0 ? setup.averaged() : std::max(1.0, setup.rate);
  for (Index i = 0; i < 7; ++i) {
    Vector3d moved = Vector3d::Zero();
    if (i > 0) moved[(i - 1) / 2] = (i % 2 == 1 ? -1.0 : 1.0) * setup.calibration;
    const Vector3d really = moved + setup.repeatability * normal.vector();
    VectorXd readings = probe_readings(setup.directions, setup.contact_radius, really);
    for (double& reading : readings) reading += setup.noise / std::sqrt(averaged) * normal();
    table.values.row(i).head<3>() = (moved / units::mm).transpose();
    table.values.row(i).tail(probes) = (readings / units::um).transpose();
  }
  return table;
}

}  // namespace

RawSignals probe_signals(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                         const std::vector<solver::Vector6>& error, const ProbeSetup& setup, std::uint64_t seed) {
  core::NormalDraws normal(seed);
  RawSignals signals;
  signals.calibration = calibration_table(setup, normal);
  const Index probes = setup.directions.cols();
  const Index samples = setup.record > 0 ? std::max<Index>(1, std::lround(setup.record * setup.rate)) : 1;
  signals.raw.source = "raw.csv";
  signals.raw.columns = {"time_s", "point"};
  for (const std::string& name : probe_columns(probes)) signals.raw.columns.push_back(name);
  signals.raw.values.resize(samples * std::ssize(points), 2 + probes);
  const int body = machine.body_index(setup.on_table ? machine.tcp.table_body : machine.tcp.tool_body);
  Index row = 0;
  for (Index p = 0; p < std::ssize(points); ++p) {
    const Eigen::Matrix3d carrier = mesh::body_transform(machine, body, points[p].pose).linear();
    const Vector3d deviation = error[p].head<3>() + setup.repeatability * normal.vector();
    const Vector3d sphere = (setup.on_table ? 1.0 : -1.0) * (carrier.transpose() * deviation);
    const VectorXd readings = probe_readings(setup.directions, setup.contact_radius, sphere);
    for (Index i = 0; i < samples; ++i, ++row) {
      const double done = i, share = samples > 1 ? done / (samples - 1) - 0.5 : 0.0;
      signals.raw.values(row, 0) = points[p].time + share * setup.record;
      signals.raw.values(row, 1) = p + 1;
      for (Index k = 0; k < probes; ++k)
        signals.raw.values(row, 2 + k) = (readings[k] + setup.noise * normal()) / units::um;
    }
  }
  return signals;
}

}  // namespace thermotwin::metrology
