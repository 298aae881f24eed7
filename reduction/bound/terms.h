// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// K(p) = K0 + sum_j p_j K_j projected on the trial space U and the dual space W of a bound (model.h), and the residuals
// of the projections, seen through the probes G. E is the capacity. A term K_j acts on few nodes (the pads of a joint,
// a wetted surface), so its projection has low rank and is stored as a product of thin matrices, exact to rounding.
// A change of p updates the sum by the changed terms only.

#include <Eigen/Core>

#include <vector>

#include "reduction/basis/basis.h"
#include "solver/thermal/system.h"

namespace thermotwin::reduction {

/// U has m columns, of which the leading `dual` ones are W.
struct BoundTerms {
  Eigen::MatrixXd base;  ///< (m + probes) x m, of K0: U^T K0 U above G^T (E U U^T K0 U - K0 U)
  /// The same for term j: left right^T over the columns first[j] to first[j + 1]. (m + probes) x r and m x r
  Eigen::MatrixXd left, right;
  std::vector<Eigen::Index> first;  ///< (terms + 1)
  Eigen::MatrixXd stored;           ///< probes x (m - dual), G^T E times the columns of U outside W

  Eigen::Index order() const { return base.cols(); }
  Eigen::Index dual() const { return base.cols() - stored.cols(); }
  Eigen::Index probes() const { return base.rows() - base.cols(); }
  Eigen::Index count() const { return std::ssize(first) - 1; }
};

/// @param u  (size x m), U^T E U = 1   @param dual  number of columns of W, whose span contains every fluid node
/// @param probes  G (size x probes)   @param stored  G^T E U (probes x m)
BoundTerms bound_terms(const solver::ThermalSystem& thermal, const Eigen::MatrixXd& u, Eigen::Index dual,
                       const RowMajorMatrix& probes, const Eigen::MatrixXd& stored);

/// K(p) on U and W with its residuals, at coefficients p.
class BoundSum {
public:
  explicit BoundSum(const BoundTerms& terms);

  /// Sets p. @param p  (terms)
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
