// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Rational Krylov bases at shifts and directions that an H2-optimal reduced model would have: the
// iteration of S. Gugercin, A. Antoulas, C. Beattie (SIAM J. Matrix Anal. Appl. 30, 2008), run on a
// projection of the system that grows by the shifts found until they stay. The reduced model matches
// the system's response and its slope at the mirrored poles of its own, along their directions. No
// bound of its error is known and stability is not certain.

#include "reduction/systems/system_solver.h"

namespace thermotwin::reduction {

struct KrylovBases {
  Eigen::MatrixXd right, left;  ///< (n x order), orthonormal columns
  bool converged = false;       ///< the shifts stay
};

KrylovBases rational_krylov(const StateSpace& system, const SystemSolver& solver, Eigen::Index order);

}  // namespace thermotwin::reduction
