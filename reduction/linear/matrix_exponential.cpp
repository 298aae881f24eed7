// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/matrix_exponential.h"

#include <unsupported/Eigen/MatrixFunctions>

namespace thermotwin::reduction {

Eigen::MatrixXd matrix_exponential(const Eigen::MatrixXd& matrix) { return matrix.exp(); }

}  // namespace thermotwin::reduction
