// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"

namespace thermotwin::compensation {
namespace {

constexpr double gap = std::numeric_limits<double>::quiet_NaN();

TEST(Measures, AgreeWithValuesByHand) {
  Eigen::VectorXd z(4), y(4);
  z << 0, 2, 4, 6;
  y << 0, 1, 5, 4;  // e = 0 1 -1 2
  const Measures m = measure(z, y);
  EXPECT_EQ(m.count, 4);
  EXPECT_NEAR(m.fit, (1 - std::sqrt(6.0) / std::sqrt(20.0)) * 100, 1e-12);
  EXPECT_NEAR(m.peak_to_peak, 3.0, 1e-15);
  EXPECT_NEAR(m.rms, std::sqrt(1.5), 1e-15);
  EXPECT_NEAR(m.maximum, 2.0, 1e-15);
  EXPECT_NEAR(m.mean, 0.5, 1e-15);
  EXPECT_NEAR(m.rms_before, std::sqrt(14.0), 1e-14);
  EXPECT_NEAR(m.peak_to_peak_before, 6.0, 1e-15);
  EXPECT_NEAR(m.maximum_before, 6.0, 1e-15);
  EXPECT_NEAR(m.rms_reduction_percent, (1 - std::sqrt(1.5 / 14.0)) * 100, 1e-12);
  EXPECT_NEAR(m.peak_to_peak_reduction_percent, 50.0, 1e-12);
}

TEST(Measures, PairsWithAGapOnEitherSideAreLeftOut) {
  Eigen::VectorXd z(6), y(6), short_z(4), short_y(4);
  z << 0, gap, 2, 4, 6, 100;
  y << 0, 50, 1, 5, 4, gap;
  short_z << 0, 2, 4, 6;
  short_y << 0, 1, 5, 4;
  const Measures with = measure(z, y), without = measure(short_z, short_y);
  EXPECT_EQ(with.count, 4);
  EXPECT_EQ(with.fit, without.fit);
  EXPECT_EQ(with.rms_before, without.rms_before);
  EXPECT_EQ(with.peak_to_peak_before, without.peak_to_peak_before);
}

TEST(Measures, APerfectPredictionFitsByHundred) {
  const Eigen::VectorXd z = Eigen::VectorXd::LinSpaced(11, -1, 1);
  const Measures m = measure(z, z);
  EXPECT_EQ(m.fit, 100.0);
  EXPECT_EQ(m.rms_reduction_percent, 100.0);
}

TEST(Measures, ThePlainMeanFitsByZeroAndWorseIsNegative) {
  const Eigen::VectorXd z = Eigen::VectorXd::LinSpaced(11, 3, 5);
  EXPECT_NEAR(measure(z, Eigen::VectorXd::Constant(11, 4.0)).fit, 0.0, 1e-12);
  EXPECT_LT(measure(z, -z).fit, 0.0);
  EXPECT_LT(measure(z, -z).rms_reduction_percent, 0.0);
}

TEST(Measures, NothingToCompareIsNoNumber) {
  const Measures m = measure(Eigen::VectorXd::Constant(3, gap), Eigen::VectorXd::Zero(3));
  EXPECT_EQ(m.count, 0);
  EXPECT_TRUE(std::isnan(m.fit));
  EXPECT_TRUE(std::isnan(m.rms_reduction_percent));
}

TEST(Measures, DifferentLengthsAreRefused) {
  EXPECT_THROW(measure(Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(4)), core::InputError);
}

}  // namespace
}  // namespace thermotwin::compensation
