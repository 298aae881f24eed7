// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// SystemSolver by sparse factorisations: Cholesky (solver/linear/sparse_factor.h) for symmetric definite
// pencils and real s, LU (sparse_lu.h) otherwise; Gramians of low rank (low_rank_adi.h); the slowest
// modes by Arnoldi's method on A^-1 E. Stability is proved where E and -(A + A^T) are positive
// definite; elsewhere eigenvalues near the imaginary axis are looked for.

#include "reduction/systems/system_solver.h"

namespace thermotwin::reduction {

/// @throws InputError as make_system_solver; an unstable eigenvalue that is not found shows as a
///         low-rank iteration that does not converge (SolverError)
std::unique_ptr<SystemSolver> make_sparse_solver(const StateSpace& system, const std::string& place,
                                                 const SolverOptions& options);

/// Whether a symmetric matrix is positive definite, well away from singular.
bool is_definite(const Sparse& matrix);

}  // namespace thermotwin::reduction
