// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One way to solve with a large symmetric positive definite matrix, by a sparse factor or by
// multigrid; which of the two is decided before memory is asked for (memory_plan.h).

#include <variant>

#include "solver/linear/linear_solver.h"
#include "solver/linear/multigrid.h"
#include "solver/linear/side_by_side.h"
#include "solver/linear/sparse_factor.h"

namespace thermotwin::solver {

struct SpdOptions {
  LinearSolver kind = LinearSolver::direct;
  SparseFactorOptions factor;  ///< direct; its block is also multigrid's
  MultigridOptions multigrid;  ///< iterative
  void validate() const;       ///< of the kind that is used  @throws InputError
};

class SpdSolver {
public:
  using Matrix = Eigen::SparseMatrix<double>;

  /// @param spd  compressed, both triangles   @param analysis  direct: made before, of the same pattern
  SpdSolver(const Matrix& spd, const SpdOptions& options, const SparseAnalysis* analysis = nullptr);

  /// New values on the same pattern; not while another thread solves.
  void factorise(const Matrix& spd);
  /// One of its own, with the same analysis where there is one, to be factorised anew.
  SpdSolver copy_for_new_values() const;

  /// A X = B; iterative: to its tolerance. Several threads at once. @throws SolverError
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_sides, Eigen::Ref<Eigen::MatrixXd> solution) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides) const;
  /// Right-hand sides side by side, as well as an outer iteration needs it: iterative: one V-cycle.
  void precondition(const Eigen::Ref<const SideBySide>& right_hand_sides, Eigen::Ref<SideBySide> solution) const;

  bool is_direct() const { return options_.kind == LinearSolver::direct; }
  double memory_bytes() const;
  /// Direct: rough reciprocal condition number; iterative: 1, a singular matrix does not converge.
  double rcond() const;

private:
  explicit SpdSolver(const SpdOptions& options) : options_(options) {}
  SpdOptions options_;
  std::variant<std::monostate, SparseFactor, MultigridSolver> solver_;
};

}  // namespace thermotwin::solver
