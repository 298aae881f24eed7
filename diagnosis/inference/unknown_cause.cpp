// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/unknown_cause.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double memories_s[] = {1800.0, 3.0 * core::units::hour};
constexpr double inflations[] = {5.0, 20.0};  ///< of what the model is said to be off by, in proportion to its response

/// What one channel adds to the normal equations.
struct Block {
  MatrixXd gram;  ///< lower half
  VectorXd right;
  double square = 0, log_determinant = 0;
};

Block block(const ChannelCovariance& covariance, const MatrixXd& columns, const VectorXd& residual) {
  const Whitener whitener({covariance});
  const MatrixXd white = whitener.whiten(columns);
  const VectorXd r = whitener.whiten(residual);
  Block result;
  result.gram = MatrixXd::Zero(columns.cols(), columns.cols());
  result.gram.selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
  result.right = white.transpose() * r;
  result.square = r.squaredNorm();
  result.log_determinant = whitener.log_determinant();
  return result;
}

Eigen::LLT<MatrixXd> factor_of(const Block& sum) {
  MatrixXd precision = sum.gram;
  precision.diagonal().array() += 1.0;
  Eigen::LLT<MatrixXd> factor(precision);
  if (factor.info() != Eigen::Success)
    throw core::SolverError("diagnosis: evidence with a residual that is not finite");
  return factor;
}

double log_evidence(const Block& sum, double rows) {
  const Eigen::LLT<MatrixXd> factor = factor_of(sum);
  const double log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  return -0.5 * (rows * std::log(2.0 * std::numbers::pi) + log_det + sum.square -
                 sum.right.dot(factor.solve(sum.right)) + sum.log_determinant);
}

void add(Block& sum, const Block& other, double sign = 1.0) {
  sum.gram += sign * other.gram;
  sum.right += sign * other.right;
  sum.square += sign * other.square;
  sum.log_determinant += sign * other.log_determinant;
}

/// All channels, those of one sort, single ones: each of the three counts the same.
/// @param groups  receives the number of those before the single ones
std::vector<std::vector<std::size_t>> scopes_of(const std::vector<ObservedChannel>& observed, std::size_t& groups) {
  const std::size_t channels = observed.size();
  std::vector<std::vector<std::size_t>> scopes(3);
  for (std::size_t k = 0; k < channels; ++k) {
    scopes[0].push_back(k);
    scopes[observed[k].is_temperature() ? 1 : 2].push_back(k);
  }
  std::erase_if(scopes,
                [&](const auto& scope) { return scope.empty() || (scope.size() == channels && &scope != &scopes[0]); });
  groups = scopes.size();
  if (channels > 1)
    for (std::size_t k = 0; k < channels; ++k) scopes.push_back({k});
  return scopes;
}

}  // namespace

UnknownEvidence unknown_evidence(const Problem& problem, const MatrixXd& of_channels, const VectorXd& prior_std,
                                 const VectorXd& residual_of_channels, const VectorXd& seen,
                                 const std::vector<double>& levels) {
  const MatrixXd columns = problem.decorrelated(of_channels);
  const VectorXd residual = problem.decorrelated(residual_of_channels);
  const auto& observed = problem.observations.channels;
  const std::size_t channels = observed.size(), wandering = levels.size() * std::size(memories_s);
  const std::size_t sizes = wandering + std::size(inflations), wide = sizes + 1;
  const std::vector<ChannelCovariance> covariance = problem.fitted_covariance();
  double rows = 0.0;
  for (const ObservedChannel& channel : observed) rows += channel.fitted;

  // Every channel as it is, then with something unknown of each size.
  std::vector<Block> blocks(channels * wide);
  core::parallel_for(0, channels, [&](std::size_t k) {
    const Index first = problem.first_row(k), n = observed[k].fitted;
    const MatrixXd own = columns.middleRows(first, n) * prior_std.asDiagonal();
    const VectorXd r = residual.segment(first, n);
    blocks[k * wide] = block(covariance[k], own, r);
    for (std::size_t s = 0; s < sizes; ++s) {
      ChannelCovariance other = covariance[k];
      if (s < wandering)
        other.wander.push_back(
            {levels[s / std::size(memories_s)] * seen[k], memories_s[s % std::size(memories_s)], {}});
      else
        other.shapes *= inflations[s - wandering];
      blocks[k * wide + s + 1] = block(other, own, r);
    }
  });
  Block nominal = blocks[0];
  for (std::size_t k = 1; k < channels; ++k) add(nominal, blocks[k * wide]);
  UnknownEvidence result;
  result.without = log_evidence(nominal, rows);

  std::size_t groups = 0;
  const std::vector<std::vector<std::size_t>> scopes = scopes_of(observed, groups);
  std::vector<double> of_scope(scopes.size());
  core::parallel_for(0, scopes.size(), [&](std::size_t i) {
    std::vector<double> logs;
    // In one temperature, what goes with the model's response is a loose sensor in steady air: that has a name.
    const bool reading = scopes[i].size() == 1 && observed[scopes[i].front()].is_temperature();
    for (std::size_t s = 0; s < (reading ? wandering : sizes); ++s) {
      Block sum = nominal;
      for (const std::size_t k : scopes[i]) add(sum, blocks[k * wide], -1.0), add(sum, blocks[k * wide + s + 1]);
      logs.push_back(log_evidence(sum, rows));
    }
    of_scope[i] = log_mean_exp(logs);
  });
  std::vector<double> sorts = {of_scope[0]};
  const auto from = [&](std::size_t first, std::size_t last) {
    return std::vector<double>(of_scope.begin() + first, of_scope.begin() + last);
  };
  if (groups > 1) sorts.push_back(log_mean_exp(from(1, groups)));
  if (scopes.size() > groups) sorts.push_back(log_mean_exp(from(groups, scopes.size())));
  const std::size_t best = std::max_element(of_scope.begin(), of_scope.end()) - of_scope.begin();
  if (best >= groups) result.channels = {best - groups};

  const Eigen::LLT<MatrixXd> factor = factor_of(nominal);
  const MatrixXd scaled = columns * prior_std.asDiagonal();
  const VectorXd mean = factor.solve(nominal.right);
  const std::vector<ReadingSteps> steps =
      find_reading_steps(problem, {scaled, residual, covariance, factor, mean}, seen, levels);
  if (!steps.empty()) {
    std::vector<double> of_steps;
    for (const ReadingSteps& one : steps) of_steps.push_back(result.without + one.log_evidence);
    sorts.push_back(log_mean_exp(of_steps));
    const std::size_t leads = std::max_element(of_steps.begin(), of_steps.end()) - of_steps.begin();
    if (of_steps[leads] > of_scope[best]) {
      result.steps = steps[leads];
      result.channels = steps[leads].channels;
    }
  }
  result.with = log_mean_exp(sorts);
  return result;
}

}  // namespace thermotwin::diagnosis
