// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Dominant subspaces of both Gramians of the machine at rest, without the transport of coolants (T. Penzl 2006). With
// the controllability Gramian P = Zb Zb^T, the observability Gramian Q = Zc Zc^T and Zc^T E Zb = U S W^T, the basis
// consists of the columns of Zb W and Zc U by falling Hankel singular value. It is orthonormal in the capacity E, so
// the projection is Galerkin's and stable for all films. Balanced truncation itself is an oblique projection, stable
// for one set of coefficients only.

#include "reduction/basis/basis.h"
#include "reduction/basis/responses.h"

namespace thermotwin::reduction {

/// @return the basis; its singular_values are the Hankel singular values from inputs at their typical sizes to
///   displacements in m  @param rows  outputs, of which the leading directions count, beside the sensors
/// @param most  largest number of columns
Basis balanced_basis(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                     const std::vector<solver::OutputRows>& rows, Eigen::Index most);

}  // namespace thermotwin::reduction
