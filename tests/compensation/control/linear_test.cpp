// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/linear.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <vector>

namespace thermotwin::compensation {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd some(int rows, int cols, unsigned seed) {
  std::srand(seed);
  return MatrixXd::Random(rows, cols);
}

TEST(ControlLinear, ProductsEqualThoseOfEigen) {
  for (const int n : {1, 3, 4, 7, 30}) {
    const MatrixXd a = some(n, n + 2, 1), b = some(n + 2, 5, 2), c = some(n, 5, 3);
    const VectorXd x = some(n + 2, 1, 4);
    VectorXd y = VectorXd::Ones(n), transposed = VectorXd::Ones(n + 2);
    tt_gemv(n, n + 2, 0.5, a.data(), x.data(), y.data());
    EXPECT_LT((y - VectorXd::Ones(n) - 0.5 * a * x).norm(), 1e-14 * n);
    tt_gemv_t(n, n + 2, 0.5, a.data(), y.data(), transposed.data());
    EXPECT_LT((transposed - VectorXd::Ones(n + 2) - 0.5 * a.transpose() * y).norm(), 1e-14 * n);
    MatrixXd product = c, inner = MatrixXd::Zero(n + 2, 5);
    tt_gemm(n, 5, n + 2, 2.0, a.data(), b.data(), product.data());
    EXPECT_LT((product - c - 2.0 * a * b).norm(), 1e-13 * n);
    tt_gemm_tn(n + 2, 5, n, 1.0, a.data(), c.data(), inner.data());
    EXPECT_LT((inner - a.transpose() * c).norm(), 1e-13 * n);
    EXPECT_NEAR(tt_norm(n, y.data()), y.norm(), 1e-14 * n);
  }
}

TEST(ControlLinear, CholeskyByPiecesOfColumnsSolves) {
  for (const int n : {1, 2, 17, 60}) {
    const MatrixXd root = some(n, n, 5), a = root * root.transpose() + 0.1 * MatrixXd::Identity(n, n);
    const VectorXd b = some(n, 1, 6);
    MatrixXd factor = a;
    for (int first = 0; first < n; first += 7)
      ASSERT_EQ(tt_cholesky_columns(n, factor.data(), first, std::min(n, first + 7)), 0);
    const MatrixXd lower = factor.triangularView<Eigen::Lower>(), exact = a.llt().matrixL();
    EXPECT_LT((lower - exact).norm(), 1e-12 * exact.norm());
    VectorXd x = b;
    tt_cholesky_solve(n, factor.data(), x.data());
    EXPECT_LT((a * x - b).norm(), 1e-10 * b.norm());
  }
  MatrixXd indefinite = MatrixXd::Identity(3, 3);
  indefinite(1, 1) = -1.0;
  EXPECT_EQ(tt_cholesky_columns(3, indefinite.data(), 0, 3), 2);
}

TEST(ControlLinear, LuByPiecesOfColumnsSolves) {
  for (const int n : {1, 2, 17, 60}) {
    const MatrixXd a = some(n, n, 7);
    const VectorXd b = some(n, 1, 8);
    MatrixXd factor = a;
    std::vector<std::int32_t> pivots(n);
    for (int first = 0; first < n; first += 5)
      ASSERT_EQ(tt_lu_columns(n, factor.data(), pivots.data(), first, std::min(n, first + 5)), 0);
    const Eigen::PartialPivLU<MatrixXd> exact(a);
    EXPECT_LT((factor - exact.matrixLU()).norm(), 1e-11 * exact.matrixLU().norm());
    VectorXd x = b;
    tt_lu_solve(n, factor.data(), pivots.data(), x.data());
    EXPECT_LT((x - exact.solve(b)).norm(), 1e-11 * x.norm() * n);
    // Other pieces do not change a bit.
    MatrixXd alone = a;
    for (int j = 0; j < n; ++j) ASSERT_EQ(tt_lu_columns(n, alone.data(), pivots.data(), j, j + 1), 0);
    EXPECT_EQ(alone, factor);
    VectorXd pieces = b;
    tt_lu_exchange(n, pivots.data(), pieces.data());
    for (int j = 0; j < n; j += 4) tt_lu_eliminate(n, factor.data(), j, std::min(n, j + 4), pieces.data());
    for (int j = n; j > 0; j -= 4) tt_lu_substitute(n, factor.data(), std::max(0, j - 4), j, pieces.data());
    EXPECT_EQ(pieces, x);
  }
  MatrixXd singular = MatrixXd::Zero(2, 2);
  singular(0, 0) = 1.0;
  std::int32_t pivots[2];
  EXPECT_EQ(tt_lu_columns(2, singular.data(), pivots, 0, 2), 2);
}

}  // namespace
}  // namespace thermotwin::compensation
