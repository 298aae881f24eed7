// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/low_rank.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <vector>

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double factor_share = 0.01;      ///< of the tolerance, for what the factor below leaves
constexpr double least_tolerance = 1e-13;  ///< what rounding leaves of it

/// L with L L^T = A up to a share of the tolerance, by Cholesky's method with pivots; no columns: A is not positive
/// semidefinite.
MatrixXd factor_of(const MatrixXd& matrix, double tolerance) {
  const Index n = matrix.rows();
  VectorXd left = matrix.diagonal();  // the diagonal of what is left
  const double largest = left.maxCoeff();
  if (!(largest > 0.0)) return {};
  MatrixXd factor(n, n);
  Index rank = 0;
  for (; rank < n; ++rank) {
    Index pivot = 0;
    const double value = left.maxCoeff(&pivot);
    if (!(value > 0.0) || left.cwiseMax(0.0).sum() <= factor_share * tolerance * largest) break;
    factor.col(rank) = matrix.col(pivot);
    factor.col(rank).noalias() -= factor.leftCols(rank) * factor.row(pivot).head(rank).transpose();
    factor.col(rank) /= std::sqrt(value);
    left -= factor.col(rank).cwiseAbs2();
    left[pivot] = 0.0;
  }
  factor.conservativeResize(Eigen::NoChange, rank);
  const MatrixXd rest = matrix - factor * factor.transpose();
  if (rest.cwiseAbs().maxCoeff() > std::max(tolerance, least_tolerance) * largest) return {};
  return factor;
}

}  // namespace

LowRank low_rank(const MatrixXd& matrix, double tolerance) {
  LowRank result;
  if (matrix == matrix.transpose()) {
    // Terms are positive semidefinite and have few directions: those of the factor cost a hundredth of the matrix's.
    if (const MatrixXd factor = factor_of(matrix, tolerance); factor.cols() > 0 && 2 * factor.cols() < matrix.cols()) {
      const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(MatrixXd(factor.transpose() * factor));
      const VectorXd& values = solver.eigenvalues();
      const Index kept = (values.array() > tolerance * values.maxCoeff()).count();
      result.left = factor * solver.eigenvectors().rightCols(kept);
      result.weight = VectorXd::Ones(kept);
      return result;
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix);
    const VectorXd& values = solver.eigenvalues();
    const double least = tolerance * values.cwiseAbs().maxCoeff();
    std::vector<Index> kept;
    for (Index i = 0; i < values.size(); ++i) {
      if (std::abs(values[i]) > least) kept.push_back(i);
    }
    result.left = solver.eigenvectors()(Eigen::all, kept) * values(kept).cwiseAbs().cwiseSqrt().asDiagonal();
    result.weight = values(kept).cwiseSign();
    return result;
  }
  const Eigen::JacobiSVD<MatrixXd> solver(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& values = solver.singularValues();
  const Index rank = std::max<Index>(1, (values.array() > tolerance * values[0]).count());
  result.left = solver.matrixU().leftCols(rank) * values.head(rank).asDiagonal();
  result.right = solver.matrixV().leftCols(rank);
  result.weight = VectorXd::Ones(rank);
  return result;
}

}  // namespace thermotwin::compensation
