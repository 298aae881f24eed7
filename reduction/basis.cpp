// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/thread_pool.h"

namespace thermotwin::reduction {
namespace {

constexpr double hourly_shift = 1.0 / 7200.0;    ///< 1/s
constexpr Eigen::Index block_columns = 48;
constexpr double dependent = 1e-13;              ///< of a squared length: 3e-7 of a length
constexpr double too_short = 1e-9;               ///< of a vector after the others are taken from it

/// X^T H X by blocks of columns.
Eigen::MatrixXd gram(const solver::SparseMatrix& energy, const Eigen::MatrixXd& x) {
  const Eigen::Index count = x.cols();
  Eigen::MatrixXd result(count, count);
  const Eigen::Index blocks = (count + block_columns - 1) / block_columns;
  core::parallel_for(0, static_cast<std::size_t>(blocks), [&](std::size_t b) {
    const Eigen::Index first = static_cast<Eigen::Index>(b) * block_columns;
    const Eigen::Index width = std::min(block_columns, count - first);
    const Eigen::MatrixXd image = energy * x.middleCols(first, width);
    result.block(first, first, count - first, width).noalias() = x.rightCols(count - first).transpose() * image;
  });
  return result.selfadjointView<Eigen::Lower>();
}

/// G = L L^T by the largest remaining diagonal entry, until nothing but rounding remains. What
/// depends on earlier columns drops out; L has as many columns as there are independent candidates.
Eigen::MatrixXd pivoted_cholesky(const Eigen::MatrixXd& g, double least) {
  const Eigen::Index n = g.rows();
  Eigen::VectorXd diagonal = g.diagonal();
  const double stop = n > 0 ? least * diagonal.maxCoeff() : 0.0;
  Eigen::MatrixXd l(n, n);
  Eigen::Index k = 0;
  for (; k < n; ++k) {
    Eigen::Index pivot = 0;
    const double most = diagonal.maxCoeff(&pivot);
    if (!(most > stop)) break;
    Eigen::VectorXd column = g.col(pivot) - l.leftCols(k) * l.row(pivot).head(k).transpose();
    column /= std::sqrt(most);
    l.col(k) = column;
    diagonal -= column.cwiseAbs2();
    diagonal(pivot) = 0.0;
  }
  return l.leftCols(k);
}

}  // namespace

Eigen::MatrixXd orthonormal(const solver::SparseMatrix& capacity, const Eigen::MatrixXd& vectors) {
  Eigen::MatrixXd basis(vectors.rows(), vectors.cols());
  Eigen::Index count = 0;
  for (Eigen::Index j = 0; j < vectors.cols(); ++j) {
    Eigen::VectorXd v = vectors.col(j);
    Eigen::VectorXd image = capacity * v;
    const double before = std::sqrt(v.dot(image));
    if (!(before > 0.0)) continue;
    double length = before;
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd shares = basis.leftCols(count).transpose() * image;
      v.noalias() -= basis.leftCols(count) * shares;
      image = capacity * v;
      length = std::sqrt(std::max(0.0, v.dot(image)));
    }
    if (length <= too_short * before) continue;
    basis.col(count++) = v / length;
  }
  return basis.leftCols(count);
}

solver::SparseMatrix energy_of(const solver::ThermalSystem& thermal, const solver::SparseMatrix& conduction) {
  return conduction + hourly_shift * thermal.capacity;
}

Eigen::MatrixXd compressed(const solver::SparseMatrix& energy, const Eigen::MatrixXd& x, double least) {
  const double below = least * least;
  const Eigen::MatrixXd factor = pivoted_cholesky(gram(energy, x), 1e-2 * below);
  if (factor.cols() == 0) return x.leftCols(0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(factor.transpose() * factor);
  const Eigen::Index count = factor.cols();
  Eigen::Index kept = 0;
  while (kept < count && eigen.eigenvalues()(count - 1 - kept) > below * eigen.eigenvalues()(count - 1)) ++kept;
  // X^T H X = F F^T with F = U S W^T, so that X U are the directions with their lengths S.
  const Eigen::MatrixXd left = factor * eigen.eigenvectors().rightCols(kept) *
                               eigen.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  return x * left;
}

Basis make_basis(const solver::ThermalSystem& thermal, const solver::SparseMatrix& conduction,
                 const Eigen::MatrixXd& candidates, Eigen::Index most) {
  const Eigen::MatrixXd factor = pivoted_cholesky(gram(energy_of(thermal, conduction), candidates), dependent);

  Basis basis;
  basis.rank = factor.cols();
  const Eigen::Index kept = std::min(basis.rank, most - 1);
  Eigen::MatrixXd directions(thermal.size, kept + 1);
  directions.col(0).setOnes();
  if (basis.rank > 0) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(factor.transpose() * factor);
    basis.singular_values = eigen.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    const Eigen::MatrixXd combination = factor * eigen.eigenvectors().rowwise().reverse().leftCols(kept);
    directions.rightCols(kept).noalias() = candidates * combination;
  }
  basis.vectors = orthonormal(thermal.capacity, directions);
  return basis;
}

Eigen::MatrixXd project(const solver::SparseMatrix& matrix, const RowMajorMatrix& vectors) {
  return project(matrix, vectors, vectors);
}

Eigen::MatrixXd project(const solver::SparseMatrix& matrix, const RowMajorMatrix& left, const RowMajorMatrix& right) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
    for (solver::SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry) rows.push_back(entry.row());
  }
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  std::vector<Eigen::Index> place(static_cast<std::size_t>(matrix.rows()), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) place[static_cast<std::size_t>(rows[i])] = static_cast<Eigen::Index>(i);

  RowMajorMatrix image = RowMajorMatrix::Zero(static_cast<Eigen::Index>(rows.size()), right.cols());
  for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
    for (solver::SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry) {
      image.row(place[static_cast<std::size_t>(entry.row())]) += entry.value() * right.row(column);
    }
  }
  const RowMajorMatrix touched = left(rows, Eigen::all);
  return touched.transpose() * image;
}

}  // namespace thermotwin::reduction
