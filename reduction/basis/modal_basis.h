// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Modal truncation: the slowest modes K v = lambda E v of the machine at one set of coefficients, by the
// Lanczos process on (K + s E)^-1 E with full reorthogonalisation (Ericsson & Ruhe 1980). It knows
// neither inputs nor outputs; it is here to be compared with.

#include "reduction/basis/basis.h"

namespace thermotwin::reduction {

/// Uniform field, then modes by falling time constant, orthonormal in E; coolants do not flow.
/// @param p  (terms) coefficients   @param most  largest number of columns
/// singular_values: time constants in s.
Basis modal_basis(const solver::ThermalSystem& thermal, const Eigen::VectorXd& p, Eigen::Index most);

}  // namespace thermotwin::reduction
