// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/evidence.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <cassert>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/error.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

LinearEvidence::LinearEvidence(const Eigen::MatrixXd& sensitivity, const Eigen::VectorXd& residual,
                               const Eigen::VectorXd& prior_std)
    : prior_std_(prior_std) {
  assert(sensitivity.rows() == residual.size() && sensitivity.cols() == prior_std.size());
  // In units of the prior, so that the matrix is 1 plus something non-negative.
  const Eigen::MatrixXd scaled = sensitivity * prior_std.asDiagonal();
  Eigen::MatrixXd precision = Eigen::MatrixXd::Identity(prior_std.size(), prior_std.size());
  precision.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  if (factor.info() != Eigen::Success)
    throw core::SolverError("diagnosis: evidence with a residual that is not finite");
  const Eigen::VectorXd b = scaled.transpose() * residual;
  const Eigen::VectorXd unit_mean = factor.solve(b);
  const double log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  chi_square_ = residual.squaredNorm() - b.dot(unit_mean);
  const double n = residual.size();
  log_evidence_ = -0.5 * (n * std::log(2.0 * std::numbers::pi) + log_det + chi_square_);
  mean_ = prior_std.cwiseProduct(unit_mean);
  covariance_ = prior_std.asDiagonal() * factor.solve(Eigen::MatrixXd::Identity(prior_std.size(), prior_std.size())) *
                prior_std.asDiagonal();
}

LinearEvidence::Widened LinearEvidence::widen(std::span<const int> which, std::span<const double> std) const {
  assert(which.size() == std.size());
  const auto k = std::ssize(which);
  Eigen::MatrixXd block(k, k);
  Eigen::VectorXd mean(k), change(k);
  double log_width = 0.0;
  for (Index i = 0; i < k; ++i) {
    const int a = which[i];
    const double wide = std[i], narrow = prior_std_[a];
    mean[i] = mean_[a];
    change[i] = 1.0 / (wide * wide) - 1.0 / (narrow * narrow);
    log_width += std::log(wide / narrow);
    for (Index j = 0; j < k; ++j) block(i, j) = covariance_(a, which[j]);
  }
  // (P + E D E^T)^-1 restricted to the block is (C^-1 + D)^-1 = C (1 + D C)^-1.
  const Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(k, k) + change.asDiagonal() * block;
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(inner);
  const Eigen::MatrixXd posterior = block * lu.inverse();
  Widened result;
  // b^T C' b - b^T C b = -m^T (1 + D C)^-1 D m on the block
  const double gain = -mean.dot(lu.solve(change.cwiseProduct(mean)));
  result.log_ratio = 0.5 * gain - 0.5 * std::log(lu.determinant()) - log_width;
  result.chi_square = chi_square_ - gain;
  // C'_II b_I + ... = (1 + C D)^-1 m
  result.mean = inner.transpose().partialPivLu().solve(mean);
  result.std = posterior.diagonal().cwiseMax(0.0).cwiseSqrt();
  return result;
}

}  // namespace thermotwin::diagnosis
