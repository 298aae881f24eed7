// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/first_order_lag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace thermotwin::core {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double tau = 50.0;

/// Classical Runge-Kutta in many small steps: another way than the code's.
template <class Input>
double integrated(double y, double duration, const Input& u) {
  constexpr int steps = 2000;
  const double h = duration / steps;
  const auto slope = [&](double at, double value) { return (u(at) - value) / tau; };
  for (int i = 0; i < steps; ++i) {
    const double t = i * h, k1 = slope(t, y), k2 = slope(t + 0.5 * h, y + 0.5 * h * k1),
                 k3 = slope(t + 0.5 * h, y + 0.5 * h * k2), k4 = slope(t + h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return y;
}

TEST(LagStep, IsExactForAnInputThatStandsAndForAStraightOne) {
  for (const double duration : {1.0, 30.0, 400.0}) {
    const LagStep step(duration, tau);
    EXPECT_NEAR(step.standing(2.0, 7.0), integrated(2.0, duration, [](double) { return 7.0; }), 1e-10);
    EXPECT_NEAR(step.straight(2.0, 3.0, 9.0),
                integrated(2.0, duration, [&](double at) { return 3.0 + 6.0 * at / duration; }), 1e-10);
  }
}

TEST(LagStep, DoesNotCancelInAShortInterval) {
  const double duration = 1e-7 * tau;
  const LagStep step(duration, tau);
  EXPECT_NEAR(step.straight(0.0, 0.0, 1.0), 0.5e-7, 1e-14);
  EXPECT_NEAR(step.standing(0.0, 1.0), 1e-7, 1e-14);
}

TEST(LagStep, WithoutALagIsTheInputAndWithoutTimeTheState) {
  EXPECT_EQ(LagStep(5.0, 0.0).standing(2.0, 7.0), 7.0);
  EXPECT_EQ(LagStep(5.0, 0.0).straight(2.0, 7.0, 8.0), 8.0);
  EXPECT_EQ(LagStep(0.0, tau).standing(2.0, 7.0), 2.0);
  EXPECT_EQ(LagStep(0.0, tau).straight(2.0, 7.0, 7.0), 2.0);
  EXPECT_EQ(LagStep(std::numeric_limits<double>::infinity(), tau).standing(2.0, 7.0), 7.0);
}

TEST(Lagged, StartsInBalanceAndFollowsLinesOrSteps) {
  const VectorXd time = Vector3d(10.0, 40.0, 140.0), values = Vector3d(3.0, 9.0, -1.0);
  const VectorXd lines = lagged_lines(time, values, tau), steps = lagged_steps(time, values, tau);
  EXPECT_EQ(lines[0], 3.0);
  EXPECT_EQ(steps[0], 3.0);
  const double at_40 = integrated(3.0, 30.0, [](double at) { return 3.0 + 0.2 * at; });
  EXPECT_NEAR(lines[1], at_40, 1e-10);
  EXPECT_NEAR(lines[2], integrated(at_40, 100.0, [](double at) { return 9.0 - 0.1 * at; }), 1e-10);
  EXPECT_NEAR(steps[1], 9.0 - 6.0 * std::exp(-0.6), 1e-12);
  EXPECT_NEAR(steps[2], -1.0 + (steps[1] + 1.0) * std::exp(-2.0), 1e-12);
  for (const double none : {0.0, -1.0}) {
    EXPECT_EQ(lagged_lines(time, values, none), values);
    EXPECT_EQ(lagged_steps(time, values, none), values);
  }
  EXPECT_EQ(lagged_lines({}, {}, tau).size(), 0);
}

}  // namespace
}  // namespace thermotwin::core
