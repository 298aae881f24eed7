// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/propagation.h"

#include <algorithm>

#include "core/error.h"
#include "core/thread_pool.h"
#include "diagnosis/response/tangents.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index columns_of_heat = 32;  ///< fixed, so that results do not depend on threads
constexpr double second_stage = (1.0 - solver::sdirk_gamma) / solver::sdirk_gamma;

[[noreturn]] void not_finite() {
  throw core::SolverError(
      "diagnosis: the reduced model's state is no longer finite; look for NaN in the measured inputs");
}

void record(const Nominal& nominal, const VectorXd& state, const Tangents& block, const std::vector<Variant>& variants,
            Index point, std::vector<MatrixXd>& out) {
  const MatrixXd all = nominal.rows * block.state();
  for (Index v = 0; v < all.cols(); ++v) {
    const std::size_t variant = block.first() + v;
    auto row = out[variant + 1].row(point);
    row = all.col(v).transpose();
    if (const MatrixXd& change = variants[variant].row_change; change.size() > 0) row += (change * state).transpose();
  }
}

}  // namespace

std::vector<MatrixXd> propagate(const Nominal& nominal, const std::vector<Variant>& variants) {
  const Index points = nominal.observations.points.size(), outputs = nominal.rows.rows();
  RunWithTangents run(nominal, variants);
  std::vector<MatrixXd> out(variants.size() + 1, MatrixXd(points, outputs));
  const auto record_all = [&](Index point) {
    out[0].row(point) = (nominal.rows * run.state()).transpose();
    core::parallel_for(0, run.blocks().size(),
                       [&](std::size_t b) { record(nominal, run.state(), *run.blocks()[b], variants, point, out); });
  };
  record_all(0);
  for (Index s = 0; s + 1 < points; ++s) {
    run.advance(s);
    record_all(s + 1);
  }
  if (!run.finite()) not_finite();
  return out;
}

std::vector<MatrixXd> propagate_heat(const Nominal& nominal, const MatrixXd& loads, const MatrixXd& series) {
  const Index points = nominal.observations.points.size(), outputs = nominal.rows.rows(),
              count = loads.cols() * series.cols();
  NominalRun run(nominal);
  const Index width = columns_of_heat, blocks = (count + width - 1) / width;
  std::vector<MatrixXd> state(blocks);
  for (Index b = 0; b < blocks; ++b) state[b].setZero(loads.rows(), std::min(width, count - b * width));
  std::vector<MatrixXd> out(count, MatrixXd::Zero(points, outputs));
  for (Index s = 0; s + 1 < points; ++s) {
    run.advance(s, 2 * count);
    core::parallel_for(0, blocks, [&](std::size_t b) {
      const Index first = b * width;
      MatrixXd& x = state[b];
      MatrixXd heat(x.rows(), x.cols());
      for (Index c = 0; c < x.cols(); ++c)
        heat.col(c) = run.scale() * series(s, (first + c) / loads.cols()) * loads.col((first + c) % loads.cols());
      const MatrixXd stage = run.solve(run.stored(x) + heat), next = x + second_stage * (stage - x);
      x = run.solve(run.stored(next) + heat);
      const MatrixXd all = nominal.rows * x;
      for (Index c = 0; c < x.cols(); ++c) out[first + c].row(s + 1) = all.col(c).transpose();
    });
    run.finish();
  }
  for (const MatrixXd& x : state)
    if (!x.allFinite()) not_finite();
  return out;
}

}  // namespace thermotwin::diagnosis
