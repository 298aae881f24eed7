// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/basis.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <set>
#include <vector>

#include "reduction/linear/lapack.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// A rod's second differences and an uneven diagonal. (n x n), positive definite
solver::SparseMatrix rod(Index n, double unevenness) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 2.0 + unevenness * (1.0 + std::sin(0.7 * i)));
    if (i > 0) entries.emplace_back(i, i - 1, -1.0), entries.emplace_back(i - 1, i, -1.0);
  }
  solver::SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

MatrixXd random(Index rows, Index columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

TEST(Basis, ColumnsOfSeveralBlocksAreOrthonormalNestedAndLoseWhatDepends) {
  const Index n = 300;
  const solver::SparseMatrix capacity = rod(n, 5.0);
  MatrixXd x = random(n, 130, 1);
  for (Index j = 0; j < x.cols(); ++j) x.col(j) *= std::pow(10.0, -0.08 * j);
  x.col(7).setZero();
  x.col(60) = 2.0 * x.col(3) - x.col(50);  // on columns of its own and of an earlier block
  x.col(101) = x.col(99) + x.col(100);
  const MatrixXd v = orthonormal(capacity, x);
  ASSERT_EQ(v.cols(), 127);
  EXPECT_LT((v.transpose() * (capacity * v) - MatrixXd::Identity(127, 127)).cwiseAbs().maxCoeff(), 1e-13);
  for (const Index few : {5, 48, 100}) {  // the first columns span what they spanned
    const MatrixXd part = orthonormal(capacity, x.leftCols(few));
    EXPECT_LT((v.leftCols(part.cols()) - part).cwiseAbs().maxCoeff(), 1e-12) << few;
  }
}

TEST(Basis, CompressedColumnsKeepTheirOuterProduct) {
  const Index n = 200;
  const solver::SparseMatrix energy = rod(n, 0.1);
  MatrixXd x = random(n, 60, 2) * random(60, 400, 3);  // rank 60 in 400 columns
  x.rightCols(100) *= 1e-2;
  const MatrixXd small = compressed(energy, x, 1e-6);
  EXPECT_EQ(small.cols(), 60);
  const MatrixXd outer = x * x.transpose();
  EXPECT_LT((small * small.transpose() - outer).norm(), 1e-9 * outer.norm());
  const MatrixXd lengths = small.transpose() * (energy * small);
  EXPECT_LT((lengths - MatrixXd(lengths.diagonal().asDiagonal())).norm(), 1e-9 * lengths.norm());
  EXPECT_EQ(compressed(energy, MatrixXd::Zero(n, 3), 1e-6).cols(), 0);
}

// The bits of a model do not follow from where its matrices lie in memory.
TEST(Basis, AMeanSquareIsTheSameWhereverItsMatrixLies) {
  const solver::SparseMatrix capacity = rod(301, 0.37);
  const MatrixXd x = random(301, 7, 4);
  const double expected = mean_square(capacity, x);
  std::vector<std::unique_ptr<char[]>> between;
  std::vector<solver::SparseMatrix> copies(40);
  std::set<std::size_t> places;
  for (std::size_t k = 0; k < copies.size(); ++k) {
    between.push_back(std::make_unique<char[]>(16 + 16 * (k % 3)));
    copies[k] = capacity;
    places.insert(reinterpret_cast<std::size_t>(copies[k].valuePtr()) % 64);
    EXPECT_EQ(mean_square(copies[k], x), expected) << k;
  }
  EXPECT_GT(places.size(), 1U);
}

TEST(Lapack, PivotedCholeskyStopsAtTheRank) {
  const MatrixXd a = random(90, 20, 4), m = a * a.transpose();
  const MatrixXd f = lapack::pivoted_cholesky(m, 1e-12);
  EXPECT_EQ(f.cols(), 20);
  EXPECT_LT((f * f.transpose() - m).norm(), 1e-12 * m.norm());
  EXPECT_EQ(lapack::pivoted_cholesky(MatrixXd::Zero(5, 5), 1e-12).cols(), 0);
}

TEST(Lapack, ProductsAndEigenvaluesOfPartsOfMatrices) {
  const MatrixXd a = random(70, 30, 5), b = random(70, 9, 6);
  MatrixXd c = MatrixXd::Constant(40, 20, 7.0);
  lapack::transposed_product(a.rightCols(21), b.leftCols(6), c.block(3, 2, 21, 6));
  EXPECT_LT((c.block(3, 2, 21, 6) - a.rightCols(21).transpose() * b.leftCols(6)).norm(), 1e-12);
  EXPECT_EQ(c.row(2).minCoeff(), 7.0);
  EXPECT_EQ(c.col(8).minCoeff(), 7.0);
  const MatrixXd m = a.transpose() * a;
  const lapack::SymmetricPair eigen = lapack::symmetric_eigen(m);
  EXPECT_LT((m * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-11 * m.norm());
  EXPECT_LT(eigen.values(0), eigen.values(29));
}

}  // namespace
}  // namespace thermotwin::reduction
