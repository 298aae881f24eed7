// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Dominant subspaces of both Gramians of the machine at rest (T. Penzl 2006): with P = Zb Zb^T, Q = Zc Zc^T
// and Zc^T E Zb = U S W^T, the columns of Zb W and Zc U by falling Hankel singular value. Both are kept
// in one orthonormal basis, so that the projection stays Galerkin's and stable for every film; balanced
// truncation itself is oblique and promises that at one set of coefficients only.

#include "reduction/basis/basis.h"
#include "reduction/basis/responses.h"

namespace thermotwin::reduction {

/// singular_values: Hankel's, of the inputs at their typical sizes to displacements in m.
/// @param rows  outputs whose leading directions are observed, with the sensors
Basis balanced_basis(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                     const std::vector<solver::OutputRows>& rows, Eigen::Index most);

}  // namespace thermotwin::reduction
