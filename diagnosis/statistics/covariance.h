// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Covariance of the difference between a measured channel and the model without any cause:
//   cov(t, t') = noise(t) [t = t'] + sum_j shape_j(t) shape_j(t') + sum_i s_i(t) s_i(t') exp(-|t - t'| / tau_i).
// [t = t'] is 1 at equal times, else 0: noise is independent between intervals. Each shape has one unknown factor. The
// shapes are the channel's own response (errors of mesh and material data) and the responses in the other directions at
// its pose (mesh error). The Ornstein-Uhlenbeck terms are errors that wander: discretisation in time and space, and
// simplifications such as lumped films. Channels are independent of each other here. Common errors of several channels
// are parameters, see evidence.h.

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <vector>

namespace thermotwin::diagnosis {

struct OrnsteinUhlenbeck {
  double std = 0;               ///< in the channel's unit
  double time_constant = 1;     ///< s
  Eigen::VectorXd course = {};  ///< (n) s_i(t) = std * course; empty: course 1
};

struct ChannelCovariance {
  Eigen::VectorXd time;            ///< (n) s, rising
  Eigen::VectorXd noise_variance;  ///< (n) > 0
  Eigen::MatrixXd shapes;          ///< (n x shapes) columns shape_j: standard deviation with sign, correlation 1
  std::vector<OrnsteinUhlenbeck> wander;

  Eigen::MatrixXd matrix() const;    ///< (n x n)
  Eigen::VectorXd variance() const;  ///< its diagonal
  /// The first n times only.
  ChannelCovariance head(Eigen::Index n) const;
};

/// Decorrelates stacked channels: x -> L^-1 x with block-diagonal L L^T. Factorised once.
class Whitener {
public:
  /// @throws SolverError if a block is not positive definite
  explicit Whitener(const std::vector<ChannelCovariance>& channels);

  Eigen::Index size() const { return offsets_.back(); }
  /// @param stacked  (size x m), channel after channel
  Eigen::MatrixXd whiten(const Eigen::MatrixXd& stacked) const;
  double log_determinant() const { return log_determinant_; }  ///< of the covariance

private:
  std::vector<Eigen::Index> offsets_;
  std::vector<Eigen::LLT<Eigen::MatrixXd>> factors_;
  double log_determinant_ = 0;
};

}  // namespace thermotwin::diagnosis
