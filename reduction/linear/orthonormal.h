// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Orthonormal columns by Householder's QR decomposition with column pivoting.

#include <Eigen/Core>

namespace thermotwin::reduction {

/// @param columns  (n x m)
/// @param independent  smallest pivot over the largest, below which a column counts as dependent on the others
/// @return (n x rank), the same span
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns, double independent);

}  // namespace thermotwin::reduction
