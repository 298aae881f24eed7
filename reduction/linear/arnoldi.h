// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Arnoldi's method with full orthogonalisation: the eigenvalues of largest modulus of an operator.

#include <Eigen/Core>

#include <functional>

namespace thermotwin::reduction {

struct ArnoldiPairs {
  Eigen::VectorXcd values;   ///< by falling modulus, conjugates together
  Eigen::MatrixXcd vectors;  ///< (n x count), of length 1
};

/// @param steps     dimension of the Krylov space, at most n
/// @param accuracy  residual of what is given back, relative to its value
ArnoldiPairs arnoldi(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& apply, Eigen::VectorXd start,
                     Eigen::Index steps, double accuracy);

}  // namespace thermotwin::reduction
