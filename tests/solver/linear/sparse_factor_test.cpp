// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/sparse_factor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::solver {

namespace {

/// Laplace-like matrix on an n^3 grid with coupled blocks of b unknowns a node.
SparseFactor::Matrix grid_matrix(int n, int b, double shift) {
  std::vector<Eigen::Triplet<double, int>> entries;
  const auto node = [&](int i, int j, int k) { return (k * n + j) * n + i; };
  const auto link = [&](int one, int other) {
    for (int r = 0; r < b; ++r) {
      for (int c = 0; c < b; ++c) {
        const double v = r == c ? 1.0 : 0.2;
        entries.emplace_back(one * b + r, one * b + c, v);
        entries.emplace_back(other * b + r, other * b + c, v);
        entries.emplace_back(one * b + r, other * b + c, -v);
        entries.emplace_back(other * b + r, one * b + c, -v);
      }
    }
  };
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        if (i + 1 < n) link(node(i, j, k), node(i + 1, j, k));
        if (j + 1 < n) link(node(i, j, k), node(i, j + 1, k));
        if (k + 1 < n) link(node(i, j, k), node(i, j, k + 1));
      }
    }
  }
  for (int d = 0; d < n * n * n * b; ++d) entries.emplace_back(d, d, shift);
  SparseFactor::Matrix matrix(n * n * n * b, n * n * n * b);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Eigen::MatrixXd some_columns(Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = std::sin(0.37 * i + 1.0);
  return m;
}

}  // namespace

TEST(SparseFactor, HalfSolveIsARootOfTheInverse) {
  for (const int n : {3, 12}) {
    const auto a = grid_matrix(n, 1, 0.1);
    const SparseFactor factor(a);
    const Eigen::MatrixXd w = factor.half_solve(Eigen::MatrixXd::Identity(a.rows(), a.rows())),
                          b = some_columns(a.rows(), 5);
    EXPECT_LT((w * (w.transpose() * b) - factor.solve(b)).norm(), 1e-12 * factor.solve(b).norm());
    EXPECT_LT((w * b - factor.half_solve(b)).norm(), 1e-12 * (w * b).norm());  // one column or many
    EXPECT_LT((w * b.col(0) - factor.half_solve(b.col(0))).norm(), 1e-12 * (w * b.col(0)).norm());
  }
}

TEST(SparseFactor, SolvesScalarAndBlockMatrices) {
  for (int block : {1, 3}) {
    for (int n : {3, 10}) {
      const auto a = grid_matrix(n, block, 0.1);
      SparseFactorOptions options;
      options.block = block;
      const SparseFactor factor(a, options);
      const Eigen::MatrixXd b = some_columns(a.cols(), 70);
      EXPECT_LT((a * factor.solve(b) - b).norm(), 1e-11 * b.norm()) << block << " " << n;
      EXPECT_GT(factor.memory_bytes(), 8.0 * a.cols());
    }
  }
}

TEST(SparseFactor, ReadsTheLowerTriangleOnly) {
  const auto a = grid_matrix(8, 1, 0.1);
  const SparseFactor::Matrix lower = a.triangularView<Eigen::Lower>();
  const Eigen::MatrixXd b = some_columns(a.cols(), 2);
  EXPECT_LT((a * SparseFactor(lower).solve(b) - b).norm(), 1e-11 * b.norm());
}

TEST(SparseFactor, TakesNewValuesOnTheSamePattern) {
  const auto a = grid_matrix(8, 1, 0.1);
  SparseFactor factor(a);
  const SparseFactor::Matrix twice = 2.0 * a;
  factor.factorise(twice);
  const Eigen::MatrixXd b = some_columns(a.cols(), 1);
  EXPECT_LT((twice * factor.solve(b) - b).norm(), 1e-11 * b.norm());
  EXPECT_THROW(factor.factorise(grid_matrix(7, 1, 0.1)), core::SolverError);
}

TEST(SparseFactor, RefusesAMatrixThatIsNotPositive) {
  EXPECT_THROW(SparseFactor(grid_matrix(8, 1, -0.5)), core::SolverError);
}

TEST(SparseFactor, SolvesFromManyThreadsWithTheSameBits) {
  const auto a = grid_matrix(12, 3, 0.05);
  SparseFactorOptions options;
  options.block = 3;
  core::set_thread_count(1);
  const SparseFactor factor(a, options);
  const Eigen::MatrixXd b = some_columns(a.cols(), 100);
  const Eigen::MatrixXd expected = factor.solve(b);
  core::set_thread_count(2);
  const SparseFactor second(a, options);
  const Eigen::MatrixXd again = second.solve(b);
  EXPECT_EQ(std::memcmp(again.data(), expected.data(), sizeof(double) * b.size()), 0);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 5; ++i)
        if (factor.solve(b) != expected) ++wrong;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  core::set_thread_count(0);
}

TEST(SparseFactor, FewColumnsAgreeWithManyInAnyLayout) {
  for (int block : {1, 3}) {
    const auto a = grid_matrix(block == 1 ? 20 : 11, block, 0.1);
    SparseFactorOptions options;
    options.block = block;
    SparseFactor factor(a, options);
    const Eigen::MatrixXd b = some_columns(a.cols(), 29);
    const Eigen::MatrixXd expected = factor.solve(b);  // CHOLMOD's own solve
    EXPECT_LT((a * expected - b).norm(), 1e-10 * b.norm());
    for (int columns : {1, 2, 4, 5, 8, 9, 12, 29}) {
      const double close = 1e-13 * expected.leftCols(columns).norm();
      EXPECT_LT((factor.solve(Eigen::MatrixXd(b.leftCols(columns))) - expected.leftCols(columns)).norm(), close)
          << columns;
      SideBySide wider = SideBySide::Constant(a.cols(), columns + 2, 7.0);  // a view into more columns
      factor.solve_side_by_side(SideBySide(b.leftCols(columns)), wider.middleCols(1, columns));
      EXPECT_LT((wider.middleCols(1, columns) - expected.leftCols(columns)).norm(), close) << columns;
      EXPECT_TRUE((wider.col(0).array() == 7.0).all() && (wider.col(columns + 1).array() == 7.0).all()) << columns;
    }
    // A clone shares the plan of the sweeps, not the values.
    SparseFactor clone = factor.clone();
    clone.factorise(2.0 * a);
    EXPECT_LT((2.0 * clone.solve(Eigen::MatrixXd(b.leftCols(3))) - expected.leftCols(3)).norm(),
              1e-13 * expected.leftCols(3).norm());
    options.force_wide = true;
    EXPECT_LT((SparseFactor(a, options).solve(Eigen::MatrixXd(b.leftCols(3))) - expected.leftCols(3)).norm(),
              1e-13 * expected.norm());
  }
}

TEST(SparseFactor, SinglePrecisionIsHalfTheMemoryAndGoodToASmallResidual) {
  const auto a = grid_matrix(20, 1, 0.1);
  SparseFactorOptions options;
  options.single_precision = true;
  SparseFactor factor(a, options);
  const SparseFactor exact(a);
  EXPECT_LT(factor.memory_bytes(), 0.6 * exact.memory_bytes());
  EXPECT_EQ(factor.rcond(), exact.rcond());
  const Eigen::MatrixXd b = some_columns(a.cols(), 29);
  const auto check = [&](const SparseFactor& of, double scale) {
    for (int columns : {1, 2, 5, 9, 12, 29}) {
      const Eigen::MatrixXd some = b.leftCols(columns), x = of.solve(some);
      const double left = (scale * (a * x) - some).norm() / some.norm();
      EXPECT_LT(left, 1e-6) << columns;
      EXPECT_GT(left, 1e-9) << columns;  // rounded indeed
      SideBySide beside(a.cols(), columns);
      of.solve_side_by_side(SideBySide(some), beside);
      EXPECT_LT((beside - x).norm(), 1e-12 * x.norm()) << columns;
    }
  };
  check(factor, 1.0);
  const SparseFactor before = factor.clone();
  factor.factorise(2.0 * a);
  check(factor, 2.0);
  check(before, 1.0);
  EXPECT_THROW(factor.half_solve(b), core::SolverError);
}

TEST(SparseFactor, SweepsHaveTheSameBitsForAnyNumberOfThreads) {
  const auto a = grid_matrix(28, 1, 0.05);  // separators at the top are shared among threads
  const SparseFactor factor(a);
  for (int columns : {1, 3, 9}) {
    const SideBySide b = some_columns(a.cols(), columns);
    SideBySide expected(b.rows(), b.cols()), again(b.rows(), b.cols());
    core::set_thread_count(1);
    factor.solve_side_by_side(b, expected);
    for (int threads : {2, 5}) {
      core::set_thread_count(threads);
      factor.solve_side_by_side(b, again);
      EXPECT_EQ(std::memcmp(again.data(), expected.data(), sizeof(double) * b.size()), 0) << columns << ' ' << threads;
    }
    core::set_thread_count(0);
    EXPECT_LT((a * expected - b).norm(), 1e-10 * b.norm());
  }
}

}  // namespace thermotwin::solver
