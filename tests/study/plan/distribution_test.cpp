// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/distribution.h"

#include <gtest/gtest.h>

#include <cmath>

namespace thermotwin::study {
namespace {

// Quantiles of the standard normal distribution, NIST tables; the shares beyond the ends are left out.
TEST(StudyDistribution, HasTheQuantilesOfTheNormalOne) {
  const Distribution standard = Distribution::normal(0.0, 1.0);
  const double beyond = 0.006209665325776132;  // share below -2.5
  const auto quantile = [&](double share) { return standard.at((share - beyond) / (1.0 - 2.0 * beyond)); };
  EXPECT_NEAR(quantile(0.975), 1.959963984540054, 1e-13);
  EXPECT_NEAR(quantile(0.5), 0.0, 1e-15);
  EXPECT_NEAR(quantile(0.01), -2.326347874040841, 1e-13);
  EXPECT_NEAR(quantile(0.99), 2.326347874040841, 1e-13);
}

TEST(StudyDistribution, EndsAtTwoAndAHalfDeviations) {
  const Distribution normal = Distribution::normal(1.0, 0.1);
  EXPECT_NEAR(normal.at(1e-12), 0.75, 1e-9);
  EXPECT_NEAR(normal.at(1.0 - 1e-12), 1.25, 1e-9);
  EXPECT_NEAR(normal.at(0.5), 1.0, 1e-12);
  const Distribution uniform = Distribution::uniform(-2.0, 4.0);
  EXPECT_DOUBLE_EQ(uniform.at(0.25), -0.5);
}

/// Mean of f over the distribution.
template <class F>
double mean(const Distribution& of, const F& f) {
  double sum = 0.0;
  constexpr int points = 20001;
  for (int i = 0; i < points; ++i) sum += f(of.at((i + 0.5) / points)) / points;
  return sum;
}

TEST(StudyDistribution, PolynomialsAreOrthonormalInIt) {
  for (const Distribution& of : {Distribution::normal(1.0, 0.1), Distribution::uniform(0.2, 3.0)}) {
    const Polynomials p(of);
    EXPECT_NEAR(mean(of, [&](double x) { return p.first(x); }), 0.0, 1e-5);
    EXPECT_NEAR(mean(of, [&](double x) { return p.first(x) * p.first(x); }), 1.0, 1e-4);
    EXPECT_NEAR(mean(of, [&](double x) { return p.second(x); }), 0.0, 1e-4);
    EXPECT_NEAR(mean(of, [&](double x) { return p.first(x) * p.second(x); }), 0.0, 1e-4);
    EXPECT_NEAR(mean(of, [&](double x) { return p.second(x) * p.second(x); }), 1.0, 1e-3);
  }
}

}  // namespace
}  // namespace thermotwin::study
