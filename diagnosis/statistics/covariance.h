// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What is expected to differ between a measured channel and the model for reasons that are no cause:
//   cov(t, t') = noise(t) [t = t'] + sum_j shape_j(t) shape_j(t') + sum_i s_i(t) s_i(t') exp(-|t - t'| / tau_i).
// Noise is independent between intervals; each shape has one unknown factor: of the channel's own response
// (mesh, material data), of the other directions at its pose (mesh); the Ornstein-Uhlenbeck terms are errors that
// wander (discretisation in time and space, what a lumped film leaves out). Channels are independent of each other
// here:
// what joins them is in the parameters, see evidence.h.

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <vector>

namespace thermotwin::diagnosis {

struct OrnsteinUhlenbeck {
  double std = 0;               ///< in the channel's unit
  double time_constant = 1;     ///< s
  Eigen::VectorXd course = {};  ///< (n) the std times this at each time; empty: 1 throughout
};

struct ChannelCovariance {
  Eigen::VectorXd time;            ///< (n) s, rising
  Eigen::VectorXd noise_variance;  ///< (n) > 0
  Eigen::MatrixXd shapes;          ///< (n x any) standard deviation times sign, each fully correlated
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
