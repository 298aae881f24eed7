// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/eigen.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace thermotwin::compensation {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A = Z D Z^T, Z^T Z = 1, and values that rise and equal those of Eigen.
void expect_decomposed(const MatrixXd& a, double scale = 1.0) {
  const auto n = static_cast<int>(a.rows());
  MatrixXd vectors = a * scale;
  VectorXd values(n), work(tt_eigen_work(n));
  ASSERT_EQ(tt_symmetric_eigen(n, vectors.data(), values.data(), work.data()), 0);
  values /= scale;
  const double size = a.norm() + std::numeric_limits<double>::min(), epsilon = 1e-15 * n;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> exact(a);
  EXPECT_LT((values - exact.eigenvalues()).cwiseAbs().maxCoeff(), 10.0 * epsilon * size) << n;
  EXPECT_LT((vectors.transpose() * vectors - MatrixXd::Identity(n, n)).norm(), 20.0 * epsilon) << n;
  EXPECT_LT((vectors * values.asDiagonal() * vectors.transpose() - a).norm(), 20.0 * epsilon * size) << n;
}

TEST(ControlEigen, DecomposesDenseMatrices) {
  std::srand(1);
  for (const int n : {1, 2, 3, 4, 9, 40, 120}) {
    const MatrixXd a = MatrixXd::Random(n, n);
    expect_decomposed(a + a.transpose());
  }
}

TEST(ControlEigen, DecomposesMatricesThatAreHardForQl) {
  expect_decomposed(MatrixXd::Zero(5, 5));
  expect_decomposed(MatrixXd::Identity(6, 6));
  expect_decomposed(MatrixXd::Ones(8, 8));      // seven equal values
  MatrixXd wilkinson = MatrixXd::Zero(21, 21);  // pairs of close values
  for (int i = 0; i < 21; ++i) wilkinson(i, i) = std::abs(i - 10);
  for (int i = 0; i < 20; ++i) wilkinson(i, i + 1) = wilkinson(i + 1, i) = 1.0;
  expect_decomposed(wilkinson);
  std::srand(2);
  const MatrixXd q = MatrixXd(MatrixXd::Random(30, 30).householderQr().householderQ());
  VectorXd decay(30);  // rates of a machine: from milliseconds to a day
  for (int i = 0; i < 30; ++i) decay[i] = 1e3 * std::pow(10.0, -0.3 * i);
  const MatrixXd graded = q * decay.asDiagonal() * q.transpose();
  expect_decomposed(0.5 * (graded + graded.transpose()));
}

TEST(ControlEigen, NeitherLargeNorSmallEntriesMatter) {
  std::srand(3);
  const MatrixXd a = MatrixXd::Random(12, 12);
  expect_decomposed(a + a.transpose(), 1e200);
  expect_decomposed(a + a.transpose(), 1e-200);
}

// Slices give the bits of all at once, and are never more than was stated.
TEST(ControlEigen, SlicesGiveTheSameBits) {
  std::srand(4);
  for (const int n : {2, 10, 100}) {
    const MatrixXd half = MatrixXd::Random(n, n), a = half + half.transpose();
    MatrixXd once = a, sliced = a;
    VectorXd values(n), values_sliced(n), work(tt_eigen_work(n));
    ASSERT_EQ(tt_symmetric_eigen(n, once.data(), values.data(), work.data()), 0);
    std::vector<std::int32_t> progress(tt_eigen_progress);
    const tt_eigen job = {n, sliced.data(), values_sliced.data(), work.data(), progress.data()};
    tt_eigen_begin(&job);
    int slices = 1;
    while (tt_eigen_slice(&job) == 0) ++slices;
    EXPECT_LE(slices, tt_eigen_slices(n));
    EXPECT_GE(slices, n);
    EXPECT_EQ(tt_eigen_slice(&job), 1) << "done stays done";
    EXPECT_TRUE(once == sliced && values == values_sliced);
  }
}

TEST(ControlEigen, SaysWhenItDoesNotConverge) {
  MatrixXd a = MatrixXd::Identity(4, 4);
  a(1, 2) = a(2, 1) = std::numeric_limits<double>::quiet_NaN();
  VectorXd values(4), work(tt_eigen_work(4));
  EXPECT_EQ(tt_symmetric_eigen(4, a.data(), values.data(), work.data()), 1);
}

}  // namespace
}  // namespace thermotwin::compensation
