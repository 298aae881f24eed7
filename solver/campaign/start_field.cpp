// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/start_field.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/layout.h"
#include "solver/thermal/direct.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void set_fluids_to_walls(const ThermalSystem& thermal, VectorXd& temperature) {
  VectorXd sum = VectorXd::Zero(thermal.size - thermal.nodes), area = sum;
  for (std::size_t t = 0; t < thermal.terms.size(); ++t) {
    if (thermal.layout.terms[t].kind != TermKind::coolant_wall) continue;
    // A wall's matrix couples its one fluid node with minus the wall's load.
    for (Index fluid = thermal.nodes; fluid < thermal.size; ++fluid) {
      for (SparseMatrix::InnerIterator it(thermal.terms[t], fluid); it; ++it) {
        if (it.row() >= thermal.nodes) continue;
        sum[fluid - thermal.nodes] -= it.value() * temperature[it.row()];
        area[fluid - thermal.nodes] -= it.value();
      }
    }
  }
  for (Index f = 0; f < sum.size(); ++f)
    if (area[f] > 0.0) temperature[thermal.nodes + f] = sum[f] / area[f];
}

VectorXd field_from_sensors(const ThermalSystem& thermal, const Coefficients& c, const std::vector<int>& sensors,
                            const VectorXd& values_K) {
  ThermalDirectSolver solver(thermal);
  solver.factorise(c.p, 0.0);
  const VectorXd steady = solver.solve(thermal.inputs * c.q);
  const auto count = std::ssize(sensors);
  MatrixXd rows(thermal.size, count);
  VectorXd off(count);
  for (Index i = 0; i < count; ++i) {
    rows.col(i) = thermal.sensors.row(sensors[i]).transpose();
    off[i] = values_K[i] - rows.col(i).dot(steady);
  }
  const MatrixXd adjoint = solver.solve(rows, true);
  const MatrixXd stored = thermal.capacity * adjoint;
  const MatrixXd gram = adjoint.transpose() * stored;
  // Sensors at one place make it singular: their mean is what can be honoured.
  const VectorXd scale = gram.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(scale.asDiagonal() * gram * scale.asDiagonal()));
  const double least = 1e-10 * eigen.eigenvalues().maxCoeff();
  const VectorXd inverse =
      eigen.eigenvalues().unaryExpr([&](double value) { return value > least ? 1.0 / value : 0.0; });
  const VectorXd weights =
      scale.asDiagonal() *
      (eigen.eigenvectors() * (inverse.asDiagonal() * (eigen.eigenvectors().transpose() * (scale.asDiagonal() * off))));
  return steady + solver.solve(stored * weights);
}

VectorXd field_from_sensors(const core::Table& table, double time_s, const OperatingModel& model,
                            const LoadProgram& program, const ThermalSystem& thermal) {
  const mesh::Machine& machine = model.machine();
  const VectorXd times = table.column("time_s");
  if (times.size() == 0 || !(time_s >= times[0] && time_s <= times[times.size() - 1])) {
    throw core::InputError(table.source, fmt::format("no rows around {} s", time_s),
                           times.size() == 0 ? std::string("a table with rows")
                                             : fmt::format("{} to {} s", times[0], times[times.size() - 1]));
  }
  std::vector<int> sensors;
  std::vector<double> values;
  VectorXd readings = VectorXd::Constant(std::ssize(machine.sensors), not_given);
  std::vector<std::string> unknown, known;
  for (const mesh::SensorSpec& sensor : machine.sensors) known.push_back(sensor.id + "_C");
  for (const std::string& column : table.columns) {
    if (column == "time_s") continue;
    const auto at = std::find(known.begin(), known.end(), column);
    if (at == known.end()) {
      unknown.push_back(column);
      continue;
    }
    const VectorXd series = table.column(column);
    Index before = -1, after = -1;
    for (Index i = 0; i < series.size(); ++i) {
      if (!std::isfinite(series[i])) continue;
      if (times[i] <= time_s) before = i;
      if (times[i] >= time_s && after < 0) after = i;
    }
    if (before < 0 || after < 0) continue;
    const double share = after > before ? (time_s - times[before]) / (times[after] - times[before]) : 0.0;
    const std::size_t sensor = at - known.begin();
    for (const Index row : {before, after})
      machine.require_plausible(series[row],
                                fmt::format("{}:{} {}", table.source, core::Table::line_of_row(row), column));
    readings[sensor] = series[before] + share * (series[after] - series[before]) - machine.reference_C;
    sensors.push_back(sensor);
    values.push_back(readings[sensor] - machine.sensors[sensor].offset);
  }
  if (!unknown.empty()) core::warn(table.source + ": columns that belong to no sensor: " + core::join(unknown));
  if (sensors.empty())
    throw core::InputError(table.source, "no sensor has a value at that time", "one or more of: " + core::join(known));

  const VectorXd row = program.row_at(0.0, 0.0);
  const int air = machine.ambient_index("air");
  const double air_K = air >= 0 ? model.ambient_K(air, row) : 0.0;
  for (double& reading : readings)
    if (!std::isfinite(reading)) reading = air_K;
  // What is observed beside the sensors is not known either.
  VectorXd all = VectorXd::Constant(thermal.sensors.rows(), air_K);
  all.head(readings.size()) = readings;
  const Coefficients c = model.coefficients(row, chiller_set_points(machine, thermal.layout, all, model.guide_K(row)));
  return field_from_sensors(thermal, c, sensors, Eigen::Map<const VectorXd>(values.data(), std::ssize(values)));
}

}  // namespace thermotwin::solver
