// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/data_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Irregular times and three temperatures that wander on different time scales.
struct Record {
  VectorXd time;
  MatrixXd temperatures;
};
Record wandering(Index n, unsigned seed) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  Record record{VectorXd(n), MatrixXd(n, 3)};
  double t = 100.0;
  for (Index i = 0; i < n; ++i) {
    record.time[i] = t;
    record.temperatures.row(i) << 20 + std::sin(t / 4000), 21 + 2 * std::cos(t / 9000), 22 + 0.5 * std::sin(t / 700) * uniform();
    t += 5.0 + 20.0 * uniform();
  }
  return record;
}

/// Lag by small steps of the exact exponential: another way than the code's.
VectorXd lagged_in_small_steps(const Record& record, Index column, double tau) {
  VectorXd y(record.time.size());
  double value = record.temperatures(0, column);
  y[0] = value;
  for (Index i = 1; i < y.size(); ++i) {
    constexpr int steps = 400;
    const double h = (record.time[i] - record.time[i - 1]) / steps;
    for (int s = 0; s < steps; ++s) {
      const double u = record.temperatures(i - 1, column) +
                       (record.temperatures(i, column) - record.temperatures(i - 1, column)) * (s + 0.5) / steps;
      value = u + (value - u) * std::exp(-h / tau);
    }
    y[i] = value;
  }
  return y;
}

TEST(StaticRegression, RecoversItsOwnLaw) {
  const Record record = wandering(400, 1);
  const VectorXd target = (record.temperatures * Eigen::Vector3d(1.5, -0.7, 3.0)).array() - 12.0;
  const auto model = make_static_regression();
  model->fit(record.time.head(200), record.temperatures.topRows(200), target.head(200));
  EXPECT_LT((model->predict(record.time, record.temperatures) - target).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(StaticRegression, GapsAreLeftOutOfTheFitAndOfThePrediction) {
  Record record = wandering(400, 2);
  VectorXd target = (record.temperatures * Eigen::Vector3d(1, 2, 3)).array() + 4.0;
  const VectorXd truth = target;
  target[3] = target[57] = std::numeric_limits<double>::quiet_NaN();
  record.temperatures(20, 1) = std::numeric_limits<double>::quiet_NaN();
  const auto model = make_static_regression();
  model->fit(record.time, record.temperatures, target);
  const VectorXd predicted = model->predict(record.time, record.temperatures);
  EXPECT_TRUE(std::isnan(predicted[20]));
  EXPECT_NEAR(predicted[57], truth[57], 1e-8);
}

TEST(StaticRegression, AConstantTemperatureDoesNoHarm) {
  Record record = wandering(300, 3);
  record.temperatures.col(1).setConstant(21.0);
  const VectorXd target = (record.temperatures * Eigen::Vector3d(1, 0, 2)).array() + 1.0;
  const auto model = make_static_regression();
  model->fit(record.time, record.temperatures, target);
  EXPECT_LT((model->predict(record.time, record.temperatures) - target).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(DataModels, TooFewRowsAreRefused) {
  const Record record = wandering(4, 4);
  for (auto make : {make_static_regression, make_first_order}) {
    EXPECT_THROW(make()->fit(record.time, record.temperatures, VectorXd::Zero(4)), core::InputError);
  }
}

TEST(FirstOrder, RecoversLagGainsAndIntercept) {
  const Record record = wandering(1500, 5);
  for (const double tau : {300.0, 3600.0}) {
    VectorXd target = VectorXd::Constant(record.time.size(), -7.0);
    const Eigen::Vector3d gains(2.0, -1.0, 0.5);
    for (Index k = 0; k < 3; ++k) target += gains[k] * lagged_in_small_steps(record, k, tau);
    const auto model = make_first_order();
    model->fit(record.time.head(900), record.temperatures.topRows(900), target.head(900));
    EXPECT_LT((model->predict(record.time, record.temperatures) - target).tail(600).cwiseAbs().maxCoeff(), 2e-3) << model->explain();
    double found = 0.0;
    ASSERT_EQ(std::sscanf(model->explain().c_str(), "tau %lf", &found), 1);
    EXPECT_NEAR(found, tau, 0.01 * tau);
  }
}

TEST(FirstOrder, TheStepResponseIsTheExponential) {
  // A temperature that jumps: two readings 1e-3 s apart.
  VectorXd time(203);
  MatrixXd temperature(203, 1);
  for (Index i = 0; i < 203; ++i) {
    time[i] = i < 2 ? -1.0 + static_cast<double>(i) : 1e-3 + 10.0 * static_cast<double>(i - 2);
    temperature(i, 0) = i < 2 ? 20.0 : 21.0;
  }
  VectorXd target(203);
  for (Index i = 0; i < 203; ++i) target[i] = i < 2 ? 0.0 : 5.0 * (1.0 - std::exp(-(time[i] - 5e-4) / 400.0));
  const auto model = make_first_order();
  model->fit(time, temperature, target);
  EXPECT_LT((model->predict(time, temperature) - target).cwiseAbs().maxCoeff(), 1e-4) << model->explain();
}

TEST(FirstOrder, AGapIsBridgedByAStraightLine) {
  Record record = wandering(600, 6);
  const VectorXd target = 2.0 * lagged_in_small_steps(record, 0, 1000.0);
  const auto model = make_first_order();
  model->fit(record.time, record.temperatures, target);
  const VectorXd whole = model->predict(record.time, record.temperatures);
  record.temperatures.middleRows(300, 4).setConstant(std::numeric_limits<double>::quiet_NaN());
  const VectorXd with_gap = model->predict(record.time, record.temperatures);
  EXPECT_TRUE(std::isnan(with_gap[301]));
  EXPECT_NEAR(with_gap[304], whole[304], 1e-3);
  EXPECT_NEAR(with_gap[599], whole[599], 1e-3);
}

}  // namespace
}  // namespace thermotwin::compensation
