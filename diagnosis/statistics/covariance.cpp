// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/statistics/covariance.h"

#include <cassert>
#include <cmath>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

Eigen::MatrixXd ChannelCovariance::matrix() const {
  const Index n = time.size();
  Eigen::MatrixXd cov = shapes * shapes.transpose();
  cov.diagonal() += noise_variance;
  for (const OrnsteinUhlenbeck& term : wander) {
    if (term.std <= 0.0) continue;
    for (Index j = 0; j < n; ++j) {
      for (Index i = j; i < n; ++i) {
        const double c = term.std * term.std * std::exp(-(time[i] - time[j]) / term.time_constant);
        cov(i, j) += c;
        if (i != j) cov(j, i) += c;
      }
    }
  }
  return cov;
}

Eigen::VectorXd ChannelCovariance::variance() const {
  Eigen::VectorXd diagonal = noise_variance + shapes.rowwise().squaredNorm();
  for (const OrnsteinUhlenbeck& term : wander) diagonal.array() += term.std * term.std;
  return diagonal;
}

ChannelCovariance ChannelCovariance::head(Index n) const {
  return {time.head(n), noise_variance.head(n), shapes.topRows(n), wander};
}

Whitener::Whitener(const std::vector<ChannelCovariance>& channels) : offsets_{0}, factors_(channels.size()) {
  for (const ChannelCovariance& channel : channels) offsets_.push_back(offsets_.back() + channel.time.size());
  core::parallel_for(0, channels.size(), [&](std::size_t c) { factors_[c].compute(channels[c].matrix()); });
  for (const auto& factor : factors_) {
    if (factor.info() != Eigen::Success)
      throw core::SolverError("diagnosis: the covariance of a channel is not positive definite; is its uncertainty 0?");
    log_determinant_ += 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  }
}

Eigen::MatrixXd Whitener::whiten(const Eigen::MatrixXd& stacked) const {
  assert(stacked.rows() == size());
  Eigen::MatrixXd white(stacked.rows(), stacked.cols());
  core::parallel_for(0, factors_.size(), [&](std::size_t c) {
    const Index first = offsets_[c], n = offsets_[c + 1] - first;
    if (n > 0) white.middleRows(first, n) = factors_[c].matrixL().solve(stacked.middleRows(first, n));
  });
  return white;
}

}  // namespace thermotwin::diagnosis
