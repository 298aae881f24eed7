// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The class beside solve_steady and solve_shifted: one analysis of the pattern, a factorisation for
// each set of coefficients and shift, many right-hand sides for each factorisation.

#include <Eigen/Core>

#include <memory>

#include "solver/thermal/system.h"

namespace thermotwin::solver {

class ThermalDirectSolver {
public:
  /// @param system  must outlive this object
  explicit ThermalDirectSolver(const ThermalSystem& system);
  ~ThermalDirectSolver();
  ThermalDirectSolver(ThermalDirectSolver&&) noexcept;

  /// Factorises shift E + K0 + sum p K. @param p (terms)  @param shift  1/s, >= 0
  /// @throws SolverError: singular (shift 0 and a body without a path to any ambient)
  void factorise(const Eigen::VectorXd& p, double shift);

  /// X with A X = B, or A^T X = B; (size x m). May be called from several threads at once.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_side, bool transpose = false) const;

  double memory_bytes() const;  ///< of the factor

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thermotwin::solver
