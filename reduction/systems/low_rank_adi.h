// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Low-rank factors of both Gramians of a large stable system by the alternating directions implicit
// iteration in the form with low-rank residuals W (P. Benner, P. Kuerschner, J. Saak, Numer. Algorithms
// 62, 2013): A Z Z^T E^T + E Z Z^T A^T + B B^T = W W^T. Both equations share the shifts and their
// factorisations; a pair of complex shifts costs one complex solve and keeps the factors real. Shifts
// are Ritz values of the newest columns.

#include <Eigen/Core>

#include <complex>
#include <functional>
#include <memory>

#include "reduction/systems/linear_system.h"

namespace thermotwin::reduction {

/// Factors of s E - A.
class ShiftFactor {
public:
  virtual ~ShiftFactor() = default;
  virtual Eigen::MatrixXcd solve(const Eigen::MatrixXcd& right_hand_sides, bool transposed) const = 0;
  /// For a real s.
  virtual Eigen::MatrixXd solve_real(const Eigen::MatrixXd& right_hand_sides, bool transposed) const = 0;
};
using Factorise = std::function<std::unique_ptr<ShiftFactor>(std::complex<double> s)>;

struct AdiOptions {
  double residual = 1e-16;  ///< |W^T W| / |B^T B| to reach, of both equations
  int most_steps = 400;
  void validate() const;  ///< @throws InputError
};

struct AdiFactors {
  Eigen::MatrixXd controllability, observability;            ///< Zb, Zc
  Eigen::MatrixXd controllability_rest, observability_rest;  ///< W of each equation
  double residual = 0;                                       ///< the larger relative one
  int steps = 0;
  double smallest_shift = 0, largest_shift = 0;  ///< moduli
};

/// @throws SolverError where the residuals do not fall
AdiFactors low_rank_gramians(const StateSpace& system, const Factorise& factorise, const AdiOptions& options = {});

}  // namespace thermotwin::reduction
