// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace thermotwin::reduction {

/// exp(M) by scaling, squaring and Pade's approximation (N. Higham 2005). @param matrix  square
Eigen::MatrixXd matrix_exponential(const Eigen::MatrixXd& matrix);

}  // namespace thermotwin::reduction
