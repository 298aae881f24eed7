// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Low-rank factors of the terms of the affine equation, in the form that the C core stores (model.h).

#include <Eigen/Core>

namespace thermotwin::compensation {

/// Symmetric: K = sum_c w_c u_c u_c^T with w = 1 or -1. Otherwise: K = sum_c u_c v_c^T.
struct LowRank {
  Eigen::MatrixXd left, right;  ///< (r x columns) u, v; right without columns: symmetric
  Eigen::VectorXd weight;       ///< (columns) w; 1 for a matrix that is not symmetric
};

/// @param matrix     (r x r)
/// @param tolerance  eigenvalues, or singular values, below this share of the largest are left out
LowRank low_rank(const Eigen::MatrixXd& matrix, double tolerance);

}  // namespace thermotwin::compensation
