// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Many fields as a few modes and coefficients: the singular value decomposition of states that come one after another,
// X = M A, without keeping them. A block of states is merged at a time (Brand 2006): with R = (1 - M M^T) B = P S,
//   [M A, B] = [M P] [A, M^T B; 0, S],
// and the leading left singular vectors of the small matrix turn [M P] into the new modes. Memory: modes and a block.

#include <Eigen/Core>

namespace thermotwin::solver {

class FieldModes {
public:
  /// @param rank  modes that are kept; inside a few more are, so that what is dropped on the way hardly counts
  explicit FieldModes(Eigen::Index rank) : rank_(rank) {}

  /// All states have one size. @return number of the state, from 0
  Eigen::Index add(const Eigen::Ref<const Eigen::VectorXd>& state);

  struct Result {
    Eigen::MatrixXd modes;         ///< (size x k) orthonormal, largest first; k at most the rank
    Eigen::MatrixXd coefficients;  ///< (k x states)
  };
  Result take();

private:
  void merge();

  Eigen::Index rank_, count_ = 0, pending_ = 0;
  Eigen::MatrixXd modes_, coefficients_, block_;
};

}  // namespace thermotwin::solver
