// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Dual norms of residuals without a solve. With M = W^-T W^-1 symmetric and positive definite,
//   r^T M^-1 r = |W^T r|^2,
// and random columns g_i = W xi_i / sqrt(k s), xi_i normal, see any set of vectors v_l that was chosen without
// them by sum_l |g^T v_l|^2 >= sum_l v_l^T M^-1 v_l, but for a share `failure` of all draws: s solves
// (s e^(1 - s))^(k / 2) = failure, Chernoff's bound of a chi-square with k degrees of freedom; sums of several
// vectors are no worse, det(1 + 2 t V) >= 1 + 2 t tr V. A thousand probes and 1e-9 cost a factor of 1.16, two hundred
// 1.43.
// Residuals of reduced trajectories are then seen through small matrices (probes x order). Compare
// O. Balabanov & A. Nouy (2019), Adv. Comput. Math. 45, and K. Smetana, O. Zahm & A. Patera (2019), SIAM J. Sci.
// Comput. 41.

#include <Eigen/Core>

#include <cstdint>

#include "solver/thermal/system.h"

namespace thermotwin::reduction {

struct ProbeOptions {
  Eigen::Index count = 1000;  ///< 0: W itself, exact, as many columns as unknowns; small models only
  double failure = 1e-9;      ///< share of draws in which a norm is seen too small
  std::uint64_t seed = 20250401;
  void validate() const;  ///< @throws InputError
};

/// The share s of a squared norm that `count` probes see at least, but for `failure` of all draws.
double certain_share(Eigen::Index count, double failure);

/// Largest M below K(p)'s symmetric part for all p >= least: K0 + sum least_j K_j without coolant flows. Parts
/// that no term holds get one spring to nothing: residuals that have no net heat there do not feel it.
/// @param loose_fields  receives the temperature fields of 1 K in these parts (size x parts)
solver::SparseMatrix least_conduction(const solver::ThermalSystem& thermal, const Eigen::VectorXd& least,
                                      Eigen::MatrixXd& loose_fields);

/// Columns g, (size x count or size). @param m  symmetric, positive definite
Eigen::MatrixXd residual_probes(const solver::SparseMatrix& m, const ProbeOptions& options);

}  // namespace thermotwin::reduction
