// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Orthonormal columns by Householder's QR decomposition with column pivoting.

#include <Eigen/Core>

namespace thermotwin::reduction {

/// @param columns  (n x m)
/// @param independent  the part of a column beside those before it, over the largest, below which it adds nothing
/// @return (n x rank), the same span
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns, double independent);

}  // namespace thermotwin::reduction
