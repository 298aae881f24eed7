// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/lag_model.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/first_order_lag.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double grid_s[] = {0, 600, 1800, 3600, 7200, 14400, 28800, 57600};
constexpr double wander_levels[] = {0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4}, wander_times[] = {3600, 10800, 43200};
constexpr double widths[] = {0.02, 0.1, 0.3, 1.0,
                             3.0};  ///< prior of a gain: this times target's spread over input's spread
constexpr double noise_factors[] = {1, 1.2, 1.5, 2, 3,
                                    5, 10,  30};  ///< of the stated uncertainty, as if independent between readings
constexpr double least_noise = 1e-3;              ///< of the target's spread
constexpr int sweeps = 3;

}  // namespace

MatrixXd LagModel::columns(const DataRecord& record) const {
  const auto elements = std::ssize(time_constants), inputs = record.inputs.cols();
  MatrixXd columns(record.time.size(), inputs * elements + 1);
  for (Index i = 0; i < inputs; ++i) {
    // Deviations from the start: an element begins in balance.
    const VectorXd input = record.inputs.col(i).array() - record.inputs(0, i);
    for (Index k = 0; k < elements; ++k)
      columns.col(i * elements + k) = core::lagged_lines(record.time, input, time_constants[k]);
  }
  columns.col(inputs * elements).setOnes();
  return columns;
}

ChannelCovariance LagModel::left_over(const DataRecord& record, const std::vector<Index>& rows) const {
  const VectorXd noise = noise_std(rows);
  return {record.time(rows), noise.cwiseAbs2(), VectorXd::Zero(noise.size()), {{wander_std, wander_time}}};
}

double LagModel::step_response(Index input, double seconds) const {
  const auto elements = std::ssize(time_constants);
  double moved = 0.0;
  for (Index k = 0; k < elements; ++k) {
    moved += gains[input * elements + k] * core::LagStep(seconds, time_constants[k]).standing(0.0, 1.0);
  }
  return moved;
}

LagModel fit_lag_model(const DataRecord& record, Index target, const std::vector<Index>& rows) {
  std::vector<Index> good;
  for (const Index row : rows)
    if (std::isfinite(record.targets(row, target))) good.push_back(row);
  const VectorXd value = record.targets(good, target);
  const Index inputs = record.inputs.cols();
  const double size = std::max(spread_of(value), 1e-6);
  const double span = good.empty() ? 0.0 : record.time[good.back()] - record.time[good.front()] + record.interval;

  LagModel best;
  for (const double tau : grid_s)
    if (tau <= span) best.time_constants.push_back(tau);
  const auto elements = std::ssize(best.time_constants);
  best.fitted = std::ssize(good);
  best.log_evidence = -std::numeric_limits<double>::infinity();
  const MatrixXd columns = best.columns(record)(good, Eigen::all);
  const VectorXd least =
      (record.channels[target].uncertainty * record.counts.col(target).cwiseMax(1.0).cwiseSqrt().cwiseInverse())
          .cwiseMax(least_noise * size);

  struct Levels {
    VectorXd widths;
    double wander, wander_time, noise;
  };
  Levels levels{VectorXd::Constant(inputs, 0.3), 0.1, 10800.0, 1.0};
  const auto attempt = [&](const Levels& tried) {
    LagModel model = best;
    model.prior_std = VectorXd::Constant(inputs * elements + 1, 3.0 * size);
    for (Index i = 0; i < inputs; ++i) {
      model.prior_std.segment(i * elements, elements)
          .setConstant(tried.widths[i] * size / std::max(spread_of(record.inputs(good, i)), 1e-9));
    }
    model.wander_std = tried.wander * size;
    model.wander_time = tried.wander_time;
    model.noise_std = tried.noise * least;
    const Whitener white({model.left_over(record, good)});
    const LinearEvidence evidence(white.whiten(columns), white.whiten(value), model.prior_std);
    model.log_evidence = evidence.log_evidence() - 0.5 * white.log_determinant();
    if (!(model.log_evidence > best.log_evidence)) return;
    model.chi_square = evidence.chi_square();
    model.gains = evidence.mean();
    model.covariance = evidence.covariance();
    best = std::move(model);
    levels = tried;
  };
  attempt(levels);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const double before = best.log_evidence;
    for (const double wander : wander_levels)
      for (const double time : wander_times) attempt({levels.widths, wander, time, levels.noise});
    for (const double noise : noise_factors) attempt({levels.widths, levels.wander, levels.wander_time, noise});
    for (Index i = 0; i < inputs; ++i) {
      for (const double width : widths) {
        Levels tried = levels;
        tried.widths[i] = width;
        attempt(tried);
      }
    }
    if (best.log_evidence - before < 1e-3) break;
  }
  return best;
}

}  // namespace thermotwin::diagnosis
