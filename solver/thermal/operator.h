// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// shift E + K0 + sum p_j K_j times vectors of several loads, each with its own p: one pass over the
// terms for all of them. For factors, values are combined on one pattern, the union of all terms,
// which is never searched again. And its solution by blocks: nodes of the bodies (symmetric; CHOLMOD
// or multigrid), then the few fluid nodes (not symmetric) by the exact Schur complement.

#include <Eigen/LU>

#include <optional>
#include <vector>

#include "solver/linear/side_by_side.h"
#include "solver/linear/spd_solver.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

class ThermalOperator {
public:
  /// @param system  must outlive this object
  explicit ThermalOperator(const ThermalSystem& system);

  Eigen::Index size() const { return system_.size; }
  Eigen::Index nodes() const { return system_.nodes; }
  Eigen::Index fluids() const { return system_.size - system_.nodes; }
  const ThermalSystem& system() const { return system_; }

  /// E X and K X. @param p (terms x loads)  @param x (size x loads), as ex and kx
  void multiply(const SideBySide& p, const SideBySide& x, SideBySide& ex, SideBySide& kx) const;
  /// (shift E + K) X, and E X if there is a place for it.
  void multiply_shifted(const SideBySide& p, double shift, const SideBySide& x, SideBySide* ex, SideBySide& ax) const;
  /// E X
  void multiply_capacity(const SideBySide& x, SideBySide& ex) const;

  /// Body block of shift E + K, full and symmetric, written into block (made at the first call).
  void body_block(const Eigen::VectorXd& p, double shift, SparseMatrix& block) const;
  /// (fluids x fluids) block of shift E + K.
  Eigen::MatrixXd fluid_block(const Eigen::VectorXd& p, double shift) const;
  /// (nodes x fluids) block of K; the block below the diagonal is its transpose.
  SparseMatrix coupling(const Eigen::VectorXd& p) const;

private:
  enum class Wanted { capacity, both, sum };
  /// e := E X; both: k := shift E X + K X too; sum: only that
  template <Wanted wanted>
  void multiply_rows(const SideBySide& p, double shift, const SideBySide& x, double* e, double* k) const;
  /// visit(column, entry of E, entry of K) for a row
  template <class Visit>
  void visit_row(Eigen::Index row, const Eigen::VectorXd& p, const Visit& visit) const;

  const ThermalSystem& system_;
  // By rows, columns sorted: E and K0 on one pattern; then each term's entries of the row.
  std::vector<int> outer_, inner_;
  std::vector<double> e_, k_;
  struct Segment {
    int term, begin;
  };
  std::vector<int> segment_outer_, term_inner_;
  std::vector<Segment> segments_;  // one more, the end
  std::vector<double> term_values_;
  // Body block: where the entries of E and K0, then of each term, go.
  std::vector<int> body_outer_, body_inner_, volume_places_;
  std::vector<std::vector<int>> term_places_;  // -1: not in the body block
};

/// Factor at given coefficients. apply() solves with the fluid block of another operator of the
/// same walls: exact for those coefficients, a good preconditioner for others.
class BlockSolver {
public:
  /// @param single_precision  of the values of a direct factor, the same each time: see SparseFactorOptions
  void factorise(const ThermalOperator& op, const Eigen::VectorXd& p, double shift, bool single_precision = false);
  /// Takes over the analysis of another solver of the same operator, to be factorised anew.
  void adopt(const BlockSolver& other) { factor_.emplace(other.factor_->copy_for_new_values()); }

  /// Schur complement of the fluid nodes for a fluid block.
  using FluidFactor = Eigen::PartialPivLU<Eigen::MatrixXd>;
  FluidFactor fluid_factor(const Eigen::MatrixXd& fluid_block) const;
  const FluidFactor& own_fluid_factor() const { return own_; }

  /// First half of a solve, all columns: x := A_bb^-1 b for the body nodes; fluid rows are copied.
  void solve_bodies(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) const;
  /// Second half for one column.
  void finish(Eigen::Ref<Eigen::VectorXd> x, const FluidFactor& fluids, bool transpose = false) const;
  /// Both for loads side by side, as well as an iteration needs it, each with its own fluid factor.
  void precondition(const Eigen::Ref<const SideBySide>& b, Eigen::Ref<SideBySide> x,
                    const std::vector<const FluidFactor*>& fluids) const;

  const SpdSolver& factor() const { return *factor_; }
  double memory_bytes() const { return factor_->memory_bytes(); }

private:
  std::optional<SpdSolver> factor_;
  SparseMatrix block_;
  SparseMatrix coupling_;  // A_bf
  SideBySide solved_;      // A_bb^-1 A_bf
  FluidFactor own_;
  Eigen::Index nodes_ = 0;
};

}  // namespace thermotwin::solver
