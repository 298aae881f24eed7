// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/spd_solver.h"

namespace thermotwin::solver {

void SpdOptions::validate() const {
  if (kind == LinearSolver::direct)
    factor.validate();
  else
    multigrid.validate();
}

SpdSolver::SpdSolver(const Matrix& spd, const SpdOptions& options, const SparseAnalysis* analysis) : options_(options) {
  options.validate();
  if (is_direct() && analysis)
    solver_.emplace<SparseFactor>(spd, options.factor, *analysis);
  else
    factorise(spd);
}

void SpdSolver::factorise(const Matrix& spd) {
  if (!is_direct())
    solver_.emplace<MultigridSolver>(spd, options_.multigrid);
  else if (auto* factor = std::get_if<SparseFactor>(&solver_))
    factor->factorise(spd);
  else
    solver_.emplace<SparseFactor>(spd, options_.factor);
}

SpdSolver SpdSolver::copy_for_new_values() const {
  SpdSolver copy(options_);
  if (const auto* factor = std::get_if<SparseFactor>(&solver_)) copy.solver_.emplace<SparseFactor>(factor->clone());
  return copy;
}

void SpdSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_sides,
                      Eigen::Ref<Eigen::MatrixXd> solution) const {
  if (const auto* factor = std::get_if<SparseFactor>(&solver_))
    factor->solve(right_hand_sides, solution);
  else
    std::get<MultigridSolver>(solver_).solve(right_hand_sides, solution);
}

Eigen::MatrixXd SpdSolver::solve(const Eigen::MatrixXd& right_hand_sides) const {
  Eigen::MatrixXd solution(right_hand_sides.rows(), right_hand_sides.cols());
  solve(right_hand_sides, solution);
  return solution;
}

void SpdSolver::precondition(const Eigen::Ref<const SideBySide>& right_hand_sides,
                             Eigen::Ref<SideBySide> solution) const {
  if (const auto* factor = std::get_if<SparseFactor>(&solver_))
    factor->solve_side_by_side(right_hand_sides, solution);
  else
    std::get<MultigridSolver>(solver_).precondition(right_hand_sides, solution);
}

double SpdSolver::memory_bytes() const {
  if (const auto* factor = std::get_if<SparseFactor>(&solver_)) return factor->memory_bytes();
  return std::get<MultigridSolver>(solver_).memory_bytes();
}

double SpdSolver::rcond() const {
  if (const auto* factor = std::get_if<SparseFactor>(&solver_)) return factor->rcond();
  return 1.0;
}

}  // namespace thermotwin::solver
