// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/minimum_norm.h"

#include <Eigen/QR>

namespace thermotwin::core {

Eigen::MatrixXd minimum_norm_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

}  // namespace thermotwin::core
