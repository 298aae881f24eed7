// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/statistics/covariance.h"

#include <cassert>
#include <cmath>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

Eigen::VectorXd std_of(const OrnsteinUhlenbeck& term, Index n) {
  if (term.course.size() == 0) return Eigen::VectorXd::Constant(n, term.std);
  return term.std * term.course;
}

}  // namespace

Eigen::MatrixXd ChannelCovariance::matrix() const {
  const Index n = time.size();
  Eigen::MatrixXd cov = shapes * shapes.transpose();
  cov.diagonal() += noise_variance;
  for (const OrnsteinUhlenbeck& term : wander) {
    if (term.std <= 0.0) continue;
    const Eigen::VectorXd std = std_of(term, n);
    for (Index j = 0; j < n; ++j) {
      for (Index i = j; i < n; ++i) {
        const double c = std[i] * std[j] * std::exp(-(time[i] - time[j]) / term.time_constant);
        cov(i, j) += c;
        if (i != j) cov(j, i) += c;
      }
    }
  }
  return cov;
}

Eigen::VectorXd ChannelCovariance::variance() const {
  Eigen::VectorXd diagonal = noise_variance + shapes.rowwise().squaredNorm();
  for (const OrnsteinUhlenbeck& term : wander) diagonal += std_of(term, time.size()).cwiseAbs2();
  return diagonal;
}

ChannelCovariance ChannelCovariance::head(Index n) const {
  ChannelCovariance first{time.head(n), noise_variance.head(n), shapes.topRows(n), wander};
  for (OrnsteinUhlenbeck& term : first.wander)
    if (term.course.size() > 0) term.course.conservativeResize(n);
  return first;
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
