// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A X = B for large symmetric positive definite A by conjugate gradients with one V-cycle of
// multigrid (multigrid_levels.h) as preconditioner. It has Chebyshev smoothing of degree 2 on the upper
// part of the diagonally scaled spectrum, and dense Cholesky on the coarsest level. Right-hand sides are
// solved in blocks, so that a matrix is read once for several of them. All loops run on the thread pool
// in fixed parts, so that results are the same bits for any number of threads.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <memory>

#include "solver/linear/side_by_side.h"

namespace thermotwin::solver {

struct MultigridOptions {
  int block = 1;              ///< consecutive unknowns per node
  Eigen::MatrixXd near_null;  ///< (n x k) vectors with A v near 0, as rigid motions; none: constants
  double tolerance = 1e-10;   ///< residual relative to the right-hand side, each column
  int max_iterations = 300;
  void validate() const;  ///< @throws InputError
};

class MultigridSolver {
public:
  using Matrix = Eigen::SparseMatrix<double>;

  /// @param spd  (n x n) compressed, both triangles; kept as a copy  @throws SolverError
  explicit MultigridSolver(const Matrix& spd, const MultigridOptions& options = {});
  ~MultigridSolver();
  MultigridSolver(MultigridSolver&&) noexcept;
  MultigridSolver& operator=(MultigridSolver&&) noexcept;

  /// May be called from several threads at once. @return iterations of the slowest column
  /// @throws SolverError if a column does not get there
  int solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_sides, Eigen::Ref<Eigen::MatrixXd> solution) const;
  /// One V-cycle from zero: symmetric, positive definite. Right-hand sides side by side.
  void precondition(const Eigen::Ref<const SideBySide>& right_hand_sides, Eigen::Ref<SideBySide> solution) const;

  Eigen::Index size() const;
  double memory_bytes() const;
  int levels() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thermotwin::solver
