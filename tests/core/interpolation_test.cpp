// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/interpolation.h"

#include <gtest/gtest.h>

#include <vector>

namespace thermotwin::core {
namespace {

TEST(LinearAt, IsLinearBetweenPointsAndConstantBeyond) {
  const std::vector<double> at{-1.0, 1.0, 5.0}, value{4.0, 8.0, -8.0};
  EXPECT_EQ(linear_at(at, value, -9.0), 4.0);
  EXPECT_EQ(linear_at(at, value, -1.0), 4.0);
  EXPECT_EQ(linear_at(at, value, -0.5), 5.0);
  EXPECT_EQ(linear_at(at, value, 1.0), 8.0);
  EXPECT_EQ(linear_at(at, value, 2.0), 4.0);
  EXPECT_EQ(linear_at(at, value, 5.0), -8.0);
  EXPECT_EQ(linear_at(at, value, 6.0), -8.0);
  EXPECT_EQ(linear_at(std::vector{2.0}, std::vector{3.0}, 7.0), 3.0);
  EXPECT_EQ(linear_at(Eigen::Vector2d(0.0, 2.0), Eigen::Vector2d(1.0, 3.0), 0.5), 1.5);
}

}  // namespace
}  // namespace thermotwin::core
