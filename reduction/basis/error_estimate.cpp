// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/error_estimate.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/statistics.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {
namespace {

constexpr double least_share = 0.1;  ///< of the largest error: below, a ratio says nothing

/// Length of dx, dy, dz in each row, um, of a table or of the difference of two.
Eigen::VectorXd translations(const core::Table& table, const core::Table* minus = nullptr) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(table.rows());
  for (const char* column : {"dx_um", "dy_um", "dz_um"}) {
    Eigen::VectorXd values = table.column(column);
    if (minus) values -= minus->column(column);
    squares += values.cwiseAbs2();
  }
  return squares.cwiseSqrt();
}

}  // namespace

double largest_translation(const core::Table& table) {
  return table.rows() == 0 ? 0.0 : translations(table).maxCoeff();
}

EstimatedRun simulate_with_estimate(const ReducedModel& model, const ReducedModel& reference,
                                    const mesh::Machine& machine, const solver::LoadProgram& load,
                                    const std::vector<mesh::Pose>& poses, ReducedRun how) {
  if (reference.system.order() <= model.system.order() || reference.machine.hash != model.machine.hash) {
    throw core::InputError(
        "reference of the error estimate",
        fmt::format("order {} for a model of order {}{}", reference.system.order(), model.system.order(),
                    reference.machine.hash == model.machine.hash ? "" : ", of another machine"),
        "a larger order of the same machine: reference.rom.h5 of the same `thermotwin reduce`");
  }
  EstimatedRun run{simulate_reduced(model, machine, load, poses, how), {}, {}};
  how.tell = false;      // the model has told what lies beyond
  how.record = nullptr;  // and what it records is its own trajectory, on which a bound is taken
  run.larger = simulate_reduced(reference, machine, load, poses, how);
  const core::Table& tcp = run.result.tcp;
  const Eigen::Index kept = 1 + machine.axes.size() + estimated_values;
  run.estimate.source = "error estimate of " + load.name();
  run.estimate.columns.assign(tcp.columns.begin(), tcp.columns.begin() + kept);
  run.estimate.values = tcp.values.leftCols(kept);
  run.estimate.values.rightCols(estimated_values) =
      run.larger.tcp.values.middleCols(kept - estimated_values, estimated_values) -
      tcp.values.middleCols(kept - estimated_values, estimated_values);
  return run;
}

Effectivity effectivity(const solver::LoadResult& full, const EstimatedRun& run) {
  const Eigen::Index rows = full.tcp.rows();
  if (rows != run.result.tcp.rows() || rows == 0) {
    throw core::InputError("effectivity of load '" + full.load + "'",
                           fmt::format("{} and {} rows", rows, run.result.tcp.rows()),
                           "results at the same times and poses");
  }
  const Eigen::VectorXd truth = translations(full.tcp, &run.result.tcp), estimated = translations(run.estimate);
  std::vector<double> ratios;
  double within = 0.0;
  const double least = least_share * truth.maxCoeff();
  for (Eigen::Index i = 0; i < rows; ++i) {
    if (!(truth(i) > 0.0) || truth(i) < least) continue;
    ratios.push_back(estimated(i) / truth(i));
    within += ratios.back() >= 0.5 && ratios.back() <= 2.0 ? 1.0 : 0.0;
  }
  Effectivity result;
  result.max_um = estimated.maxCoeff();
  if (ratios.empty()) return result;
  result.median = core::quantile(ratios, 0.5);
  result.low = core::quantile(ratios, 0.05);
  result.high = core::quantile(ratios, 0.95);
  result.within_two = within / ratios.size();
  return result;
}

}  // namespace thermotwin::reduction
