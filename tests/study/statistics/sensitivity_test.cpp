// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/statistics/sensitivity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "study/plan/design.h"

namespace thermotwin::study {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The g-function (Saltelli and Sobol 1995) of values in [0, 1], with the shares that it is known to have.
struct GFunction {
  VectorXd a;
  double operator()(const VectorXd& x) const {
    double product = 1.0;
    for (Eigen::Index i = 0; i < a.size(); ++i) product *= (std::abs(4.0 * x[i] - 2.0) + a[i]) / (1.0 + a[i]);
    return product;
  }
  double part(Eigen::Index i) const { return 1.0 / 3.0 / std::pow(1.0 + a[i], 2); }
  double variance() const {
    double product = 1.0;
    for (Eigen::Index i = 0; i < a.size(); ++i) product *= 1.0 + part(i);
    return product - 1.0;
  }
  double first(Eigen::Index i) const { return part(i) / variance(); }
  double total(Eigen::Index i) const { return part(i) * (1.0 + variance()) / (1.0 + part(i)) / variance(); }
};

bool holds(const Share& share, double value) { return share.low - 1e-12 <= value && value <= share.high + 1e-12; }

TEST(Sensitivity, WhereNothingVariesNothingHasAShare) {
  const std::vector<Distribution> two(2, Distribution::uniform(0, 1));
  MatrixXd outputs = MatrixXd::Constant(40, 3, 7.0);
  outputs.col(1) += 1e-13 * VectorXd::LinSpaced(40, 0, 1);
  for (const Sensitivity& found :
       {pick_freeze(outputs, 2), by_regression(0.5 * (MatrixXd::Random(40, 2).array() + 1.0), two, outputs)}) {
    ASSERT_EQ(found.total.size(), 2U);
    for (const auto* shares : {&found.first, &found.total})
      for (const Share& share : *shares) EXPECT_EQ(std::max({share.value, share.low, share.high}), 0.0);
  }
}

TEST(Sensitivity, PickFreezeIntervalsHoldTheKnownShares) {
  const GFunction g{(VectorXd(5) << 0.0, 0.5, 1.0, 3.0, 9.0).finished()};
  int held = 0, all = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    constexpr int samples = 800, d = 5;
    const MatrixXd shares = drawn_shares(samples, 2 * d, seed, false);
    MatrixXd outputs(samples * (d + 2), 1);
    for (int s = 0; s < samples; ++s) {
      const VectorXd a = shares.row(s).head(d), b = shares.row(s).tail(d);
      outputs(s * (d + 2), 0) = g(a);
      outputs(s * (d + 2) + 1, 0) = g(b);
      for (int i = 0; i < d; ++i) {
        VectorXd ab = a;
        ab[i] = b[i];
        outputs(s * (d + 2) + 2 + i, 0) = g(ab);
      }
    }
    const Sensitivity found = pick_freeze(outputs, d);
    for (int i = 0; i < d; ++i) {
      held += holds(found.first[i], g.first(i)) + holds(found.total[i], g.total(i));
      all += 2;
      EXPECT_NEAR(found.first[i].value, g.first(i), 0.15) << seed << " " << i;
      EXPECT_NEAR(found.total[i].value, g.total(i), 0.15) << seed << " " << i;
    }
  }
  EXPECT_GE(held, 0.90 * all) << all;
  EXPECT_LE(held, 0.98 * all) << all;
}

/// Pick-freeze rows of a function of uniform values.
template <class Function>
MatrixXd pick_freeze_rows(const Function& of, int d, int samples, int seed) {
  const MatrixXd shares = drawn_shares(samples, 2 * d, seed, false);
  MatrixXd outputs(samples * (d + 2), 1);
  for (int s = 0; s < samples; ++s) {
    const VectorXd a = shares.row(s).head(d), b = shares.row(s).tail(d);
    outputs(s * (d + 2), 0) = of(a);
    outputs(s * (d + 2) + 1, 0) = of(b);
    for (int i = 0; i < d; ++i) {
      VectorXd ab = a;
      ab[i] = b[i];
      outputs(s * (d + 2) + 2 + i, 0) = of(ab);
    }
  }
  return outputs;
}

TEST(Sensitivity, PickFreezeOfFewSamplesStaysInItsIntervals) {
  // One value makes nine tenths of the variance, as a power does, beside a product of the two others.
  const auto of = [](const VectorXd& x) { return 3.0 * x[0] + 0.8 * (1.0 + x[1]) * (0.5 + x[2]); };
  const double b = 0.64 / 12.0, first1 = b, first2 = b * 2.25, both = 0.64 / 144.0, all = 0.75 + first1 + first2 + both;
  const double first[] = {0.75 / all, first1 / all, first2 / all};
  const double total[] = {0.75 / all, (first1 + both) / all, (first2 + both) / all};
  for (const int samples : {12, 50}) {
    int held = 0, count = 0;
    double square = 0.0;
    for (int seed = 1; seed <= 100; ++seed) {
      const Sensitivity found = pick_freeze(pick_freeze_rows(of, 3, samples, seed), 3);
      for (int i = 0; i < 3; ++i) {
        for (const Share& share : {found.first[i], found.total[i]}) {
          EXPECT_LE(0.0, share.low) << samples << " " << seed << " " << i;
          EXPECT_LE(share.low, share.value) << samples << " " << seed << " " << i;
          EXPECT_LE(share.value, share.high) << samples << " " << seed << " " << i;
          EXPECT_LE(share.high, 1.0) << samples << " " << seed << " " << i;
        }
        held += holds(found.first[i], first[i]) + holds(found.total[i], total[i]);
        count += 2;
      }
      square += std::pow(found.first[0].value - first[0], 2) / 100.0;
    }
    EXPECT_GE(held, 0.90 * count) << samples;
    EXPECT_LE(held, 0.98 * count) << samples;
    EXPECT_LT(std::sqrt(square), samples == 50 ? 0.08 : 0.22) << samples;
  }
}

TEST(Sensitivity, PickFreezeOfWhatMakesNoDifferenceIsZero) {
  const MatrixXd rows = pick_freeze_rows([](const VectorXd& x) { return x[0]; }, 2, 30, 1);
  const Sensitivity found = pick_freeze(rows, 2), none = pick_freeze(MatrixXd::Ones(4 * 30, 1), 2);
  EXPECT_NEAR(found.first[0].value, 1.0, 0.02);
  EXPECT_NEAR(found.total[0].value, 1.0, 0.4);
  for (const Share& share : {found.first[1], found.total[1], none.first[0], none.total[0]}) {
    EXPECT_NEAR(share.value, 0.0, 1e-9);
    EXPECT_NEAR(share.low, 0.0, 1e-9);
    EXPECT_NEAR(share.high, 0.0, 1e-6);
  }
}

/// Two outputs that are smooth in six factors, with a product and a part that no polynomial of degree 2 has.
struct Smooth {
  static constexpr int d = 6;
  VectorXd operator()(const VectorXd& u) const {  // u: uniform in [-1, 1]
    VectorXd y(2);
    y[0] = 5.0 * u[0] + 2.0 * u[1] + 1.5 * u[0] * u[1] + 0.8 * std::sin(2.0 * std::numbers::pi * u[2]);
    y[1] = 3.0 * u[3] + 2.0 * (u[4] * u[4] - 1.0 / 3.0);
    return y;
  }
  /// Contributions to the sum of the variances.
  static VectorXd first() { return (VectorXd(d) << 25.0 / 3, 4.0 / 3, 0.32, 3.0, 4.0 * 4.0 / 45.0, 0.0).finished(); }
  static double product() { return 2.25 / 9.0; }
  static double variance() { return first().sum() + product(); }
};

TEST(Sensitivity, RegressionIntervalsHoldTheKnownShares) {
  const Smooth smooth;
  const std::vector<Distribution> distributions(Smooth::d, Distribution::uniform(-1.0, 1.0));
  int held = 0, all = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const MatrixXd u = 2.0 * drawn_shares(200, Smooth::d, seed, false).array() - 1.0;
    MatrixXd outputs(u.rows(), 2);
    for (int s = 0; s < u.rows(); ++s) outputs.row(s) = smooth(u.row(s).transpose()).transpose();
    const Sensitivity found = by_regression(u, distributions, outputs);
    EXPECT_LT(found.unexplained, 0.06);
    for (int i = 0; i < Smooth::d; ++i) {
      if (i == 2) continue;  // the sine: not a polynomial, of the remainder
      const double first = Smooth::first()[i] / Smooth::variance();
      held += holds(found.first[i], first);
      ++all;
      EXPECT_NEAR(found.first[i].value, first, 0.06) << seed << " " << i;
    }
    const double total = (Smooth::first()[0] + Smooth::product()) / Smooth::variance();
    EXPECT_TRUE(holds(found.total[0], total)) << seed;
    EXPECT_TRUE(holds(found.total[2], Smooth::first()[2] / Smooth::variance())) << seed;
  }
  EXPECT_GE(held, 0.90 * all) << all;
  EXPECT_LE(held, 0.98 * all) << all;
}

TEST(Sensitivity, AProductBelongsToTheTotalsOfBoth) {
  // y = u0 + 3 u1 u2: variances 1/3 and 9/9.
  const MatrixXd u = 2.0 * drawn_shares(120, 3, 5, true).array() - 1.0;
  const VectorXd y = u.col(0) + 3.0 * u.col(1).cwiseProduct(u.col(2));
  const Sensitivity found = by_regression(u, std::vector<Distribution>(3, Distribution::uniform(-1.0, 1.0)), y);
  EXPECT_EQ(found.products, 1U);
  EXPECT_LT(found.unexplained, 1e-3);
  const double totals[] = {0.25, 0.75, 0.75}, firsts[] = {0.25, 0.0, 0.0};
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(found.total[i].value, totals[i], 0.03) << i;
    EXPECT_NEAR(found.first[i].value, firsts[i], 0.03) << i;
  }
}

TEST(Sensitivity, NoiseDoesNotRaiseTheShares) {
  // One value tells a tenth of the variance; the rest is noise that no value tells.
  const std::vector<Distribution> distributions(2, Distribution::uniform(-1.0, 1.0));
  constexpr int seeds = 200, samples = 30;
  double mean = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const MatrixXd u = 2.0 * drawn_shares(samples, 3, seed, false).array() - 1.0;
    const VectorXd y = u.col(0) + 3.0 * u.col(2);
    mean += by_regression(u.leftCols(2), distributions, y).first[0].value / seeds;
  }
  EXPECT_NEAR(mean, 0.1, 0.03);
}

TEST(Sensitivity, OfManyOutputsIsThatOfTheirScores) {
  MatrixXd few = drawn_shares(40, 3, 3, false), spread = drawn_shares(3, 300, 4, false);
  const MatrixXd many = few * spread;
  const MatrixXd scores = scores_of(many);
  EXPECT_LE(scores.cols(), 4);
  const MatrixXd centred = many.rowwise() - many.colwise().mean();
  EXPECT_NEAR((scores * scores.transpose() - centred * centred.transpose()).norm(), 0.0, 1e-6 * centred.squaredNorm());
}

TEST(Sensitivity, AsksForEnoughSamples) {
  const std::vector<Distribution> distributions(3, Distribution::uniform(0.0, 1.0));
  EXPECT_THROW(by_regression(MatrixXd::Random(9, 3), distributions, MatrixXd::Random(9, 2)), core::InputError);
  EXPECT_NO_THROW(by_regression(MatrixXd::Random(10, 3), distributions, MatrixXd::Random(10, 2)));
  EXPECT_THROW(pick_freeze(MatrixXd::Random(15, 1), 3), core::InputError);
}

}  // namespace
}  // namespace thermotwin::study
