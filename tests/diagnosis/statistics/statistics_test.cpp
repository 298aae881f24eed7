// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/statistics/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

using namespace thermotwin::diagnosis;
using Eigen::Index;
using Eigen::VectorXd;

VectorXd noise(Index n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return VectorXd::NullaryExpr(n, [&] { return normal(random); });
}

TEST(Statistics, ChiSquareTailHasKnownValues) {
  // Two degrees of freedom: exp(-x/2). One: erfc(sqrt(x/2)). Ten: the table's 5 % point.
  for (const double x : {0.1, 1.0, 5.0, 30.0}) {
    EXPECT_NEAR(chi_square_tail(x, 2), std::exp(-x / 2), 1e-12);
    EXPECT_NEAR(chi_square_tail(x, 1), std::erfc(std::sqrt(x / 2)), 1e-12);
  }
  EXPECT_NEAR(chi_square_tail(18.307, 10), 0.05, 1e-5);
  EXPECT_NEAR(chi_square_tail(124.342, 100), 0.05, 1e-5);
}

TEST(Statistics, FTailHasKnownValues) {
  // Two degrees of freedom above: (1 + 2 F / below)^(-below / 2).
  for (const double below : {4.0, 10.0, 144.0}) {
    for (const double ratio : {0.5, 3.0, 9.0})
      EXPECT_NEAR(f_tail(ratio, 2, below), std::pow(1 + 2 * ratio / below, -below / 2), 1e-12);
  }
  EXPECT_EQ(f_tail(0.0, 5, 10), 1.0);
}

TEST(Statistics, WhiteNoiseIsToldFromADrift) {
  int low = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) low += white_noise_p_value(noise(200, seed)) < 0.05;
  EXPECT_GT(low, 1);
  EXPECT_LT(low, 24);  // 5 % of 200 within four standard deviations
  VectorXd drift = noise(200, 5);
  for (Index i = 1; i < drift.size(); ++i) drift[i] += 0.8 * drift[i - 1];
  EXPECT_LT(white_noise_p_value(drift), 1e-6);
}

TEST(Statistics, BootstrapIntervalCoversARealGainAndNoGain) {
  const VectorXd left = noise(300, 11);
  const VectorXd before = (2.0 * left + noise(300, 12)).cwiseAbs2();
  const Interval gain = reduction_interval(before, noise(300, 12).cwiseAbs2(), 12);
  EXPECT_GT(gain.low, 40);
  EXPECT_LT(gain.high, 70);
  EXPECT_LT(gain.low, 100 * (1 - 1 / std::sqrt(5.0)));
  EXPECT_GT(gain.high, 100 * (1 - 1 / std::sqrt(5.0)));
  const Interval none = reduction_interval(noise(300, 1).cwiseAbs2(), noise(300, 2).cwiseAbs2(), 12);
  EXPECT_LT(none.low, 0);
  EXPECT_GT(none.high, 0);
}

TEST(Statistics, AFewMeansAreNoProofOfAGain) {
  const Eigen::VectorXd before = Eigen::VectorXd::Constant(4, 4.0), after = Eigen::VectorXd::Constant(4, 1.0);
  EXPECT_GT(reduction_interval(before, after, 2).low, 49.0);
  EXPECT_EQ(reduction_interval(before.head(3), after.head(3), 2).low, 0.0);
  EXPECT_EQ(reduction_interval(after.head(3), before.head(3), 2).high, 0.0);
}

TEST(Statistics, BootstrapIsRepeatableAndWiderForLongerMemory) {
  const VectorXd before = VectorXd::Constant(240, 4.0);
  VectorXd after = noise(240, 3);
  for (Index i = 1; i < after.size(); ++i) after[i] += 0.95 * after[i - 1];
  after = after.cwiseAbs2().eval();
  const Interval a = reduction_interval(before, after, 24), b = reduction_interval(before, after, 24);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  const Interval short_blocks = reduction_interval(before, after, 1);
  EXPECT_GT(a.high - a.low, short_blocks.high - short_blocks.low);
}

TEST(Statistics, RootMeanSquareLeavesMissingValuesOut) {
  EXPECT_DOUBLE_EQ(root_mean_square((VectorXd(3) << 3, std::nan(""), 4).finished()), std::sqrt(12.5));
  EXPECT_EQ(root_mean_square(VectorXd()), 0.0);
  EXPECT_DOUBLE_EQ(spread_of((VectorXd(3) << 13, std::nan(""), 14).finished()), 0.5);
  EXPECT_EQ(spread_of((VectorXd(2) << 13, std::nan("")).finished()), 0.0);
}

}  // namespace
