// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// shift E + K0 + sum p_j K_j on one pattern, the union of all terms: values are combined where
// coefficients change, the pattern is never searched again. And its solution by blocks: nodes of
// the bodies (symmetric, CHOLMOD), then the few fluid nodes (not symmetric) by the exact Schur
// complement.

#include <Eigen/LU>
#include <optional>
#include <vector>

#include "solver/sparse_factor.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

class ThermalOperator {
 public:
  /// @param system  must outlive this object
  explicit ThermalOperator(const ThermalSystem& system);

  Eigen::Index size() const { return system_.size; }
  Eigen::Index nodes() const { return system_.nodes; }
  Eigen::Index fluids() const { return system_.size - system_.nodes; }
  const ThermalSystem& system() const { return system_; }

  /// Values of K0 + sum p_j K_j on the pattern. @param p (terms)
  void combine(const Eigen::VectorXd& p, Eigen::VectorXd& k_values) const;

  /// E x and K x in one pass, rows in parallel. All (size).
  void multiply(const Eigen::VectorXd& k_values, const double* x, double* ex, double* kx) const;

  /// Body block of shift E + K, full and symmetric, written into block (made at the first call).
  void body_block(const Eigen::VectorXd& k_values, double shift, SparseMatrix& block) const;
  /// (fluids x fluids) block of shift E + K.
  Eigen::MatrixXd fluid_block(const Eigen::VectorXd& k_values, double shift) const;
  /// (nodes x fluids) block of K, dense; the block below the diagonal is its transpose.
  Eigen::MatrixXd coupling(const Eigen::VectorXd& k_values) const;

 private:
  const ThermalSystem& system_;
  std::vector<int> outer_, inner_;           // by rows, columns sorted
  Eigen::VectorXd e_values_, k0_values_;
  std::vector<std::vector<int>> places_;     // of each term's entries
  std::vector<int> body_outer_, body_inner_, body_places_;
};

/// Factor at given coefficients. apply() solves with the fluid block of another operator of the
/// same walls: exact for those coefficients, a good preconditioner for others.
class BlockSolver {
 public:
  void factorise(const ThermalOperator& op, const Eigen::VectorXd& k_values, double shift);
  /// Takes over the analysis of another solver of the same operator, to be factorised anew.
  void adopt(const BlockSolver& other) { factor_.emplace(other.factor_->clone()); }

  /// Schur complement of the fluid nodes for a fluid block.
  using FluidFactor = Eigen::PartialPivLU<Eigen::MatrixXd>;
  FluidFactor fluid_factor(const Eigen::MatrixXd& fluid_block) const;
  const FluidFactor& own_fluid_factor() const { return own_; }

  /// First half of a solve, all columns: x := A_bb^-1 b for the body nodes; fluid rows are copied.
  void solve_bodies(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) const;
  /// The same, as well as an iteration needs it.
  void precondition_bodies(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) const { solve_bodies(b, x); }
  /// Second half for one column.
  void finish(Eigen::Ref<Eigen::VectorXd> x, const FluidFactor& fluids, bool transpose = false) const;

  const SparseFactor& factor() const { return *factor_; }
  double memory_bytes() const { return factor_->memory_bytes(); }

 private:
  std::optional<SparseFactor> factor_;
  SparseMatrix block_;
  Eigen::MatrixXd coupling_, solved_;  // A_bf and A_bb^-1 A_bf
  FluidFactor own_;
  Eigen::Index nodes_ = 0;
};

}  // namespace thermotwin::solver
