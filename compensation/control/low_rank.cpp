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

LowRank low_rank(const MatrixXd& matrix, double tolerance) {
  LowRank result;
  if (matrix == matrix.transpose()) {
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
