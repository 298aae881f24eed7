// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The terms of K(p) on the spaces of a bound (model.h), with the residuals that they leave there, and their
// sum at coefficients. A term acts on few nodes, the pads of a joint or a wetted surface, so what it does on
// U is of low rank: both are kept as products of thin matrices, complete to rounding. A sum follows changes of p
// by the terms that change.

#include <Eigen/Core>

#include <vector>

#include "reduction/basis/basis.h"
#include "solver/thermal/system.h"

namespace thermotwin::reduction {

/// With probes G, U (m columns) and its leading columns W.
struct BoundTerms {
  Eigen::MatrixXd base;  ///< (m + probes) x m, of K0: U^T K0 U above G^T (E U U^T K0 U - K0 U)
  /// left right^T is the same of a term: its columns from first[j] to first[j + 1]. (m + probes) x r and m x r
  Eigen::MatrixXd left, right;
  std::vector<Eigen::Index> first;  ///< (terms + 1)
  Eigen::MatrixXd stored;           ///< probes x (m - dual), G^T E of the columns beside W

  Eigen::Index order() const { return base.cols(); }
  Eigen::Index dual() const { return base.cols() - stored.cols(); }
  Eigen::Index probes() const { return base.rows() - base.cols(); }
  Eigen::Index count() const { return std::ssize(first) - 1; }
};

/// @param u  (size x m), U^T E U = 1   @param dual  columns of W, which hold every fluid node   @param probes  G (size
///   x probes)
/// @param stored  G^T E U
BoundTerms bound_terms(const solver::ThermalSystem& thermal, const Eigen::MatrixXd& u, Eigen::Index dual,
                       const RowMajorMatrix& probes, const Eigen::MatrixXd& stored);

/// K(p) on U and W, and its residuals.
class BoundSum {
public:
  explicit BoundSum(const BoundTerms& terms);

  /// Coefficients of all terms from now on.
  void set(const Eigen::VectorXd& p);

  /// U^T K(p) U
  auto conduction() const { return sum_.topRows(terms_.order()); }
  /// G^T (E U U^T K(p) U - K(p) U)
  auto residual() const { return sum_.bottomRows(terms_.probes()); }
  /// G^T (E W W^T K(p)^T W - K(p)^T W)
  Eigen::MatrixXd dual_residual() const;

private:
  const BoundTerms& terms_;
  Eigen::VectorXd p_;
  Eigen::MatrixXd sum_;
};

}  // namespace thermotwin::reduction
