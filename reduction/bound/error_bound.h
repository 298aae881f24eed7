// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A bound of |full - reduced| for every TCP output at every output time, for the p(t) and q(t) of the reduced run and
// the time steps of the full model (SDIRK2, exactly solved). docs/explanation/bound.md derives it. A second Galerkin
// solution y_U in U runs beside the model:
//   |y_full - y_model| <= |y_U - y_model| + |y_full - y_U|.
// Discrete duality: with stage residuals R_i of U and stage adjoints mu_i of the output at step n, both of the
// transposed scheme, y_full - y_U = sum mu_i^T R_i = sum (mu_i - nu_i)^T R_i for any nu_i in U, here Galerkin's
// adjoint in W. With stages paired by a, a_ij <d_i, d_j>_M, the transposed scheme dissipates
//   |e'|_E^2 + g h sum a_ij d_i^T K_s d_j <= |e|_E^2 + sum a_ij d_i^T rho_j,
//   a = [4 - 2 r2, 2 - 2 r2; 2 - 2 r2, 4],  r2 = sqrt 2,  g = 1 - 1/r2,
// (its rest is a square in g h K d), so that Cauchy-Schwarz over all steps gives
// |y_full - y_U| <= D P,  D^2 = sum a_ij rho_i^T M^-1 rho_j / (g h),  P^2 = g h sum (a^-1)_ij r_i^T M^-1 r_j, R = g h
// r, for any M <= K_s(p), the symmetric part. The norms X_w of the adjoint's error over windows w of steps satisfy
// sum X_w^2 <= sum X_w D_w. With two windows, the steps since the last output (1) and those before (2), the bound is
// (D P + D_1 P_1 + D_2 P_2) / 2. This is nearly half of D P, since D is large for the last steps only and P where
// coefficients have just changed. D^2 is a quadratic form of the output's row in W, carried forward in time, so one run
// serves all output times and poses. Chillers and coefficients that follow temperatures have those of the reduced run.

#include "reduction/basis/reduce.h"
#include "reduction/bound/model.h"
#include "reduction/model/reduced_simulation.h"

namespace thermotwin::reduction {

struct ErrorBound {
  core::Table table;        ///< time_s, pose, dx_um .. rc_um_per_m: the bound; a row for each time and pose
  double largest_um = 0;    ///< largest length of the bounds of the three translations
  double remainder_um = 0;  ///< the same of the second term, |y_full - y_U|
  double scale = 1;         ///< factor on that term where coefficients fall below those of the norm
  double failure = 0;       ///< share of draws of probes for which any number of the table may be too small
};

/// @param run  of model, as simulate_reduced records it
/// @throws InputError: another machine, other terms; a run that did not step by SDIRK2
ErrorBound error_bound(const ReducedModel& model, const BoundModel& bound, const mesh::Machine& machine,
                       const RunRecord& run);

}  // namespace thermotwin::reduction
