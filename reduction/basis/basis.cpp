// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/basis.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/thread_pool.h"
#include "reduction/linear/lapack.h"
#include "solver/linear/side_by_side.h"

namespace thermotwin::reduction {
namespace {

constexpr double hourly_shift = 1.0 / 7200.0;  ///< 1/s
constexpr Eigen::Index gram_columns = 256, block_columns = 48;
constexpr int chunk_columns = 12;
constexpr double dependent = 1e-13;  ///< of a squared length: 3e-7 of a length
constexpr double too_short = 1e-9;   ///< of a vector after the others are taken from it

Eigen::Index chunks_of(Eigen::Index columns) { return (columns + chunk_columns - 1) / chunk_columns; }

/// Columns `first` and those after it of M X, M symmetric. Rows of X lie side by side: one pass over M serves them all.
template <int W>
void image_of_columns(const solver::SparseMatrix& symmetric, const Eigen::Ref<const Eigen::MatrixXd>& x,
                      Eigen::Index first, Eigen::MatrixXd& image) {
  const solver::SideBySide rows = x.middleCols(first, W);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    solver::RowSum<W> sum;
    for (solver::SparseMatrix::InnerIterator entry(symmetric, i); entry; ++entry)
      sum.add(entry.value(), &rows(entry.row(), 0));
    double sums[W];
    sum.put(sums);
    for (int k = 0; k < W; ++k) image(i, first + k) = sums[k];
  }
}

/// M X, M symmetric
Eigen::MatrixXd image_of(const solver::SparseMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& x) {
  Eigen::MatrixXd image(x.rows(), x.cols());
  core::parallel_for(0, chunks_of(x.cols()), [&](Eigen::Index c) {
    const Eigen::Index begin = c * chunk_columns, count = std::min<Eigen::Index>(x.cols() - begin, chunk_columns);
    solver::over_columns<chunk_columns>(count, [&](auto width, Eigen::Index first) {
      image_of_columns<decltype(width)::value>(matrix, x, begin + first, image);
    });
  });
  return image;
}

/// Lower triangle of X^T H X; what is above is not set.
Eigen::MatrixXd gram(const solver::SparseMatrix& energy, const Eigen::MatrixXd& x) {
  const Eigen::Index count = x.cols();
  Eigen::MatrixXd result(count, count);
  for (Eigen::Index first = 0; first < count; first += gram_columns) {
    const Eigen::Index width = std::min(gram_columns, count - first);
    lapack::transposed_product(x.rightCols(count - first), image_of(energy, x.middleCols(first, width)),
                               result.block(first, first, count - first, width));
  }
  return result;
}

}  // namespace

Eigen::MatrixXd orthonormal(const solver::SparseMatrix& capacity, const Eigen::MatrixXd& vectors) {
  Eigen::MatrixXd basis(vectors.rows(), vectors.cols());
  Eigen::Index count = 0;
  for (Eigen::Index first = 0; first < vectors.cols(); first += block_columns) {
    // A block against those before it by products of matrices, then its columns one by one.
    Eigen::MatrixXd block = vectors.middleCols(first, std::min(block_columns, vectors.cols() - first));
    const Eigen::RowVectorXd before = (block.array() * image_of(capacity, block).array()).colwise().sum().sqrt();
    const Eigen::Index start = count;
    for (int pass = 0; pass < 2 && start > 0; ++pass) {
      Eigen::MatrixXd shares(start, block.cols());
      lapack::transposed_product(basis.leftCols(start), image_of(capacity, block), shares);
      lapack::subtract_product(basis.leftCols(start), shares, block);
    }
    for (Eigen::Index j = 0; j < block.cols(); ++j) {
      if (!(before[j] > 0.0)) continue;
      Eigen::VectorXd v = block.col(j), image = capacity * v;
      double length = 0.0;
      for (int pass = 0; pass < 2; ++pass) {
        const auto own = basis.middleCols(start, count - start);
        v.noalias() -= own * (own.transpose() * image).eval();
        image = capacity * v;
        length = std::sqrt(std::max(0.0, v.dot(image)));
      }
      if (length <= too_short * before[j]) continue;
      basis.col(count++) = v / length;
    }
  }
  return basis.leftCols(count);
}

double mean_square(const solver::SparseMatrix& capacity, const Eigen::MatrixXd& block) {
  double squares = 0.0;
  for (Eigen::Index first = 0; first < block.cols(); first += gram_columns) {
    const auto part = block.middleCols(first, std::min(gram_columns, block.cols() - first));
    squares += (part.array() * image_of(capacity, part).array()).sum();
  }
  // A sparse matrix's own sum adds in an order that follows from the place of its values in memory.
  return squares / Eigen::VectorXd(capacity * Eigen::VectorXd::Ones(capacity.cols())).sum();
}

solver::SparseMatrix energy_of(const solver::ThermalSystem& thermal, const solver::SparseMatrix& conduction) {
  return conduction + hourly_shift * thermal.capacity;
}

Eigen::MatrixXd compressed(const solver::SparseMatrix& energy, const Eigen::MatrixXd& x, double least) {
  const double below = least * least;
  const Eigen::MatrixXd factor = lapack::pivoted_cholesky(gram(energy, x), 1e-2 * below);
  if (factor.cols() == 0) return x.leftCols(0);
  const lapack::SymmetricPair eigen = lapack::symmetric_eigen(lapack::product(factor.transpose(), factor));
  const Eigen::Index count = factor.cols();
  Eigen::Index kept = 0;
  while (kept < count && eigen.values(count - 1 - kept) > below * eigen.values(count - 1)) ++kept;
  // X^T H X = F F^T with F = U S W^T, so that X U are the directions with their lengths S.
  const Eigen::MatrixXd left =
      factor * eigen.vectors.rightCols(kept) * eigen.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  return lapack::product(x, left);
}

Basis make_basis(const solver::ThermalSystem& thermal, const solver::SparseMatrix& conduction,
                 const Eigen::MatrixXd& candidates, Eigen::Index most) {
  const Eigen::MatrixXd factor = lapack::pivoted_cholesky(gram(energy_of(thermal, conduction), candidates), dependent);

  Basis basis;
  basis.rank = factor.cols();
  const Eigen::Index kept = std::min(basis.rank, most - 1);
  Eigen::MatrixXd directions(thermal.size, kept + 1);
  directions.col(0).setOnes();
  if (basis.rank > 0) {
    const lapack::SymmetricPair eigen = lapack::symmetric_eigen(lapack::product(factor.transpose(), factor));
    basis.singular_values = eigen.values.reverse().cwiseMax(0.0).cwiseSqrt();
    const Eigen::MatrixXd combination = factor * eigen.vectors.rowwise().reverse().leftCols(kept);
    directions.rightCols(kept) = lapack::product(candidates, combination);
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
  std::vector<Eigen::Index> place(matrix.rows(), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) place[rows[i]] = i;

  RowMajorMatrix image = RowMajorMatrix::Zero(std::ssize(rows), right.cols());
  for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
    for (solver::SparseMatrix::InnerIterator entry(matrix, column); entry; ++entry) {
      image.row(place[entry.row()]) += entry.value() * right.row(column);
    }
  }
  const RowMajorMatrix touched = left(rows, Eigen::all);
  return touched.transpose() * image;
}

}  // namespace thermotwin::reduction
