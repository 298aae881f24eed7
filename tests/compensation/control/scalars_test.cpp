// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/scalars.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/compensation/control/rich_machine.h"

namespace thermotwin::compensation {
namespace {

using test::Uniform;

/// Units in the last place of the true value.
double ulps(double value, long double truth) {
  const double near = std::abs(static_cast<double>(truth));
  const double unit = std::nextafter(near, std::numeric_limits<double>::infinity()) - near;
  return static_cast<double>(std::abs(static_cast<long double>(value) - truth)) / unit;
}

TEST(ControlScalars, AgreeWithLibmToTheLastPlace) {
  Uniform number(1);
  double exp = 0, log = 0, pow = 0, cbrt = 0, turn = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = number(-700.0, 700.0), size = std::exp(number(-60.0, 60.0)), y = number(-3.0, 3.0);
    const double near_1 = number(0.7, 1.4), angle = number(-20.0, 20.0);
    exp = std::max(exp, ulps(tt_exp(x), std::exp(1.0L * x)));
    log = std::max({log, ulps(tt_log(size), std::log(1.0L * size)), ulps(tt_log(near_1), std::log(1.0L * near_1))});
    pow = std::max(pow, ulps(tt_pow(size, y), std::pow(1.0L * size, 1.0L * y)));
    cbrt = std::max({cbrt, ulps(tt_cbrt(size), std::cbrt(1.0L * size)), ulps(tt_cbrt(-size), std::cbrt(-1.0L * size))});
    turn = std::max({turn, ulps(tt_sin(angle), std::sin(1.0L * angle)), ulps(tt_cos(angle), std::cos(1.0L * angle))});
  }
  EXPECT_LT(exp, 1.5);
  EXPECT_LT(log, 1.0);
  EXPECT_LT(pow, 1.5);
  EXPECT_LT(cbrt, 1.5);
  EXPECT_LT(turn, 1.5);
}

TEST(ControlScalars, EndsOfTheirRangesAreDefined) {
  EXPECT_EQ(tt_exp(-1e4), 0.0);
  EXPECT_EQ(tt_exp(1e4), std::numeric_limits<double>::infinity());
  EXPECT_EQ(tt_exp(0.0), 1.0);
  EXPECT_EQ(tt_pow(0.0, 0.25), 0.0);
  EXPECT_EQ(tt_pow(5.0, 0.0), 1.0);
  EXPECT_EQ(tt_cbrt(0.0), 0.0);
  EXPECT_TRUE(std::isnan(tt_log(-1.0)));
  EXPECT_TRUE(std::isnan(tt_pow(-1.0, 0.5)));
  EXPECT_TRUE(std::isnan(tt_exp(tt_nan())));
  EXPECT_TRUE(std::isnan(tt_sin(std::numeric_limits<double>::infinity())));
  EXPECT_EQ(tt_sin(0.0), 0.0);
  EXPECT_EQ(tt_cos(0.0), 1.0);
  EXPECT_TRUE(tt_is_nan(std::nan("")));
  EXPECT_FALSE(tt_is_nan(std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(tt_is_finite(-std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(tt_is_finite(std::numeric_limits<double>::max()));
}

}  // namespace
}  // namespace thermotwin::compensation
