// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/readings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/statistics/statistics.h"

namespace {

using namespace thermotwin;
using diagnosis::root_mean_square, diagnosis::without_noise;
using Eigen::VectorXd;

VectorXd noisy(const VectorXd& truth, double std, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, std);
  VectorXd values = truth;
  for (double& value : values) value += noise(random);
  return values;
}

TEST(WithoutNoise, ASteadyAirLosesItsNoise) {
  const VectorXd truth = VectorXd::Constant(400, 21.0), values = noisy(truth, 0.05, 7);
  EXPECT_LT(root_mean_square(without_noise(values) - truth), 0.2 * root_mean_square(values - truth));
}

TEST(WithoutNoise, ASlowSwingStaysAndItsNoiseGoes) {
  VectorXd truth(400);  // rows of five minutes, a swing of 2 K in eight hours
  for (Eigen::Index i = 0; i < truth.size(); ++i) truth[i] = 21.0 + 2.0 * std::sin(2.0 * M_PI * i / 96.0);
  const VectorXd values = noisy(truth, 0.2, 8);
  EXPECT_LT(root_mean_square(without_noise(values) - truth), 0.75 * root_mean_square(values - truth));
}

TEST(WithoutNoise, WhatSwingsWithinHalfAnHourIsNoNoise) {
  VectorXd truth(400);
  for (Eigen::Index i = 0; i < truth.size(); ++i) truth[i] = 21.0 + 0.5 * std::sin(2.0 * M_PI * i / 6.0);
  EXPECT_EQ(without_noise(truth), truth);
  EXPECT_LT(root_mean_square(without_noise(noisy(truth, 0.02, 9)) - truth), 0.03);
}

TEST(WithoutNoise, FewValuesAndGapsStayAsTheyAre) {
  const VectorXd few = noisy(VectorXd::Constant(10, 21.0), 0.05, 10);
  EXPECT_EQ(without_noise(few), few);
  VectorXd gap = noisy(VectorXd::Constant(100, 21.0), 0.05, 11);
  gap[40] = std::nan("");
  const VectorXd after = without_noise(gap);
  EXPECT_EQ(after.head(40), gap.head(40));
  EXPECT_TRUE(std::isnan(after[40]));
}

}  // namespace
