// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// SystemSolver by dense factorisations. With T^-1 (E^-1 A) T = S triangular, the Gramians' factors
// come from Hammarling's method in the form for few inputs (S. Hammarling, IMA J. Numer. Anal. 2, 1982):
// X = U U^H solves S X + X S^H + B B^H = 0 column by column from the last one on, without X ever
// being formed, so that small Hankel singular values keep their digits. Symmetric systems (E positive
// definite) have S diagonal and stay real.

#include "reduction/systems/system_solver.h"

namespace thermotwin::reduction {

std::unique_ptr<SystemSolver> make_dense_solver(const StateSpace& system, const std::string& place);

/// U, upper triangular, of S U U^H + U U^H S^H + B B^H = 0.
/// @param triangular  upper triangular with diagonal in the left half plane  @param input  (n x m)
Eigen::MatrixXcd lyapunov_factor(const Eigen::MatrixXcd& triangular, Eigen::MatrixXcd input);

/// The same for a real diagonal S.
Eigen::MatrixXd lyapunov_factor(const Eigen::VectorXd& diagonal, Eigen::MatrixXd input);

}  // namespace thermotwin::reduction
