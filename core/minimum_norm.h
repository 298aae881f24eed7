// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Linear least squares of any rank, compiled once.

#include <Eigen/Core>

namespace thermotwin::core {

/// x that makes |a x - b| least; where several do, the shortest. By a complete orthogonal decomposition.
/// @param a  (m x n)  @param b  (m x k)  @return (n x k)
Eigen::MatrixXd minimum_norm_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace thermotwin::core
