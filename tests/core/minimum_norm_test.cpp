// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/minimum_norm.h"

#include <gtest/gtest.h>

namespace thermotwin::core {
namespace {

TEST(MinimumNorm, IsTheLeastSquaresSolutionOfFullRank) {
  Eigen::MatrixXd a(4, 2), b(4, 1);
  a << 1, 0, 1, 1, 1, 2, 1, 3;
  b << 1, 3, 5, 8;
  const Eigen::MatrixXd x = minimum_norm_solution(a, b);
  EXPECT_NEAR(x(0), 0.8, 1e-12);
  EXPECT_NEAR(x(1), 2.3, 1e-12);
}

TEST(MinimumNorm, IsTheShortestWhereSeveralFit) {
  Eigen::MatrixXd a(2, 3), b(2, 2);
  a << 1, 1, 0, 2, 2, 0;  // the second row repeats the first, the last unknown has no equation
  b << 2, 1, 4, 2;
  const Eigen::MatrixXd x = minimum_norm_solution(a, b);
  Eigen::MatrixXd shortest(3, 2);
  shortest << 1, 0.5, 1, 0.5, 0, 0;
  EXPECT_NEAR((x - shortest).norm(), 0.0, 1e-12) << x;
}

}  // namespace
}  // namespace thermotwin::core
