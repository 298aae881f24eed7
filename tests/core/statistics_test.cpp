// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace thermotwin::core {
namespace {

TEST(Statistics, OrderStatistics) {
  const std::vector<double> values{5.0, 1.0, 4.0, 2.0};
  EXPECT_EQ(nth_smallest(values, 0), 1.0);
  EXPECT_EQ(nth_smallest(values, 3), 5.0);
  EXPECT_EQ(median(values), 4.0) << "the larger one in the middle";
  EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({7.0}), 7.0);
}

TEST(Statistics, QuantilesAreLinearBetweenValues) {
  const std::vector<double> values{30.0, 10.0, 20.0};
  EXPECT_EQ(quantile(values, 0.0), 10.0);
  EXPECT_EQ(quantile(values, 0.25), 15.0);
  EXPECT_EQ(quantile(values, 0.5), 20.0);
  EXPECT_EQ(quantile(values, 1.0), 30.0);
  EXPECT_EQ(quantile(values, 7.0), 30.0);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Statistics, UniformNumbersAreTheEngineSBits) {
  std::mt19937_64 engine(5489);
  EXPECT_EQ(uniform(engine), static_cast<double>(14514284786278117030ULL >> 11U) * 0x1p-53) << "the standard's first";
  double least = 1.0, most = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double value = uniform(engine);
    least = std::min(least, value);
    most = std::max(most, value);
  }
  EXPECT_GE(least, 0.0);
  EXPECT_LT(least, 1e-3);
  EXPECT_GT(most, 1.0 - 1e-3);
  EXPECT_LT(most, 1.0);
}

}  // namespace
}  // namespace thermotwin::core
