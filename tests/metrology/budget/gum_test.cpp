// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/gum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace thermotwin::metrology {
namespace {

Budget budget_of(const char* name) {
  return Budget::load(std::string(THERMOTWIN_SOURCE_DIR) + "/cases/budgets/" + name);
}

// JCGM 100:2008, H.2: table H.4 with the values that the unrounded readings give.
TEST(Gum, SimultaneousReadingsOfJcgm100) {
  const GumResult found = gum(budget_of("jcgm100_h2.toml"));
  EXPECT_NEAR(found.value[0], 127.732, 5e-4);
  EXPECT_NEAR(found.value[1], 219.847, 5e-4);
  EXPECT_NEAR(found.value[2], 254.260, 5e-4);
  EXPECT_NEAR(found.std[0], 0.071, 5e-4);
  EXPECT_NEAR(found.std[1], 0.296, 5e-4);
  EXPECT_NEAR(found.std[2], 0.236, 5e-4);
  EXPECT_NEAR(found.correlation(0, 1), -0.588, 5e-4);
  EXPECT_NEAR(found.correlation(0, 2), -0.485, 5e-4);
  EXPECT_NEAR(found.correlation(1, 2), 0.993, 5e-4);
  EXPECT_NEAR(found.degrees_of_freedom[0], 4.0, 1e-9) << "one set of five readings";
  EXPECT_NEAR(found.factor[0], 2.776, 5e-4);
}

// The same from the rounded deviations and correlations that the guide prints (0.295 for X): rounding moves u by 0.001.
TEST(Gum, RoundedInputsOfJcgm100) {
  const Budget budget = Budget::parse(R"toml(schema = 1
coverage.factor = 2
input = [{name = "V", value = 4.9990, std = 0.0032}, {name = "I", value = 19.6610, std = 0.0095},
         {name = "phi", value = 1.04446, std = 0.00075}]
correlation = [{between = ["V", "I"], coefficient = -0.36}, {between = ["V", "phi"], coefficient = 0.86},
               {between = ["I", "phi"], coefficient = -0.65}]
quantity = [{name = "R", formula = "1000*V/I*cos(phi)"}, {name = "X", formula = "1000*V/I*sin(phi)"},
            {name = "Z", formula = "1000*V/I"}])toml",
                                      "h2.toml");
  const GumResult found = gum(budget);
  EXPECT_NEAR(found.std[0], 0.071, 1.1e-3);
  EXPECT_NEAR(found.std[1], 0.295, 1e-3);
  EXPECT_NEAR(found.std[2], 0.236, 1e-3);
}

// Gebhardt (2014), Table A.1: 0.52, 1.05 and 1.81 um.
TEST(Gum, RTestDeviceOfTableA1) {
  const Budget budget = budget_of("rtest_probe.toml");
  EXPECT_NEAR(budget.probability, 0.9545, 1e-4) << "that of k = 2";
  const GumResult found = gum(budget);
  EXPECT_NEAR(found.std[0], 0.523, 1e-3);
  EXPECT_NEAR(found.expanded[0], 1.05, 5e-3);
  EXPECT_NEAR(found.expanded[1], 1.81, 5e-3);
  const double printed[] = {0.038, 0.289, 0.352, 0.029, 0.176, 0.058, 0.144, 0.058, 0.070};
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(found.contribution(0, i), printed[i], 1e-9) << i;
}

// JCGM 100, H.1: 50.000838 mm, u 32 nm, 16 degrees of freedom, U99 93 nm with the truncated degrees.
TEST(Gum, EndGaugeWithHalfWidthsOfFewDegreesOfFreedom) {
  const GumResult found = gum(Budget::parse(R"toml(schema = 1
coverage = {probability = 0.99}
input = [{name = "ls", unit = "nm", value = 50000623, std = 25, degrees_of_freedom = 18},
         {name = "d", unit = "nm", value = 215, std = 9.7, degrees_of_freedom = 25.6},
         {name = "alpha", unit = "1/K", value = 11.5e-6, distribution = "rectangular", half_width = 2e-6},
         {name = "theta", unit = "K", value = -0.1, std = 0.41},
         {name = "da", unit = "1/K", distribution = "rectangular", half_width = 1e-6, degrees_of_freedom = 50},
         {name = "dt", unit = "K", distribution = "rectangular", half_width = 0.05, degrees_of_freedom = 2}]
quantity = [{name = "l", unit = "nm", formula = "ls + d - ls * (da * theta + alpha * dt)"}])toml",
                                            "end_gauge.toml"));
  EXPECT_NEAR(found.value[0], 50000838.0, 0.5);
  EXPECT_NEAR(found.std[0], 32.0, 0.5);
  EXPECT_NEAR(found.degrees_of_freedom[0], 16.7, 0.1);
  EXPECT_NEAR(found.expanded[0], 92.0, 0.5);
}

// JCGM 100, G.4.1: u1 = 0.25 with 9, u2 = 0.57 with 4 and u3 = 0.82 with 14 degrees of freedom have 19.0 together.
TEST(Gum, EffectiveDegreesOfFreedomByWelchAndSatterthwaite) {
  const Budget budget = Budget::parse(R"toml(schema = 1
input = [{name = "a", value = 1, std = 0.25, degrees_of_freedom = 9}, {name = "b", std = 0.57, degrees_of_freedom = 4},
         {name = "c", std = 0.82, degrees_of_freedom = 14}, {name = "d", std = 0}]
quantity = [{name = "y", formula = "a + b + c + d"}, {name = "still", formula = "d"}])toml",
                                      "b.toml");
  const GumResult found = gum(budget);
  EXPECT_NEAR(found.degrees_of_freedom[0], 19.0, 0.05);
  EXPECT_NEAR(found.std[0], 1.03, 5e-3);
  EXPECT_EQ(found.std[1], 0.0);
  EXPECT_EQ(found.correlation(0, 1), 0.0);
}

// u^2 = 1 + 1 + 2 * 0.5 = 3 of a and b together, 1 of c: nu = 1 / ((3/4)^2 / 5 + (1/4)^2 / 10).
TEST(Gum, CorrelatedInputsHaveTheFewestDegreesAmongThem) {
  for (const char* degrees : {"degrees_of_freedom = 5}, {name = \"b\", value = 0, std = 1, degrees_of_freedom = 50",
                              "degrees_of_freedom = 50}, {name = \"b\", value = 0, std = 1, degrees_of_freedom = 5"}) {
    const std::string text = std::string("schema = 1\ninput = [{name = \"a\", value = 0, std = 1, ") + degrees +
                             "}, {name = \"c\", value = 0, std = 1, degrees_of_freedom = 10}]\n"
                             "correlation = [{between = [\"a\", \"b\"], coefficient = 0.5}]\n"
                             "quantity = [{name = \"y\", formula = \"a + b + c\"}]\n";
    const GumResult found = gum(Budget::parse(text, "groups.toml"));
    EXPECT_NEAR(found.std[0], 2.0, 1e-9);
    EXPECT_NEAR(found.degrees_of_freedom[0], 1.0 / (0.5625 / 5.0 + 0.0625 / 10.0), 1e-6) << degrees;
  }
}

TEST(Gum, SensitivitiesAreSlopes) {
  const Budget budget = Budget::parse(R"toml(schema = 1
input = [{name = "a", value = 0.7, std = 0.2}, {name = "b", value = 3e6, std = 0.001}]
quantity = [{name = "y", formula = "exp(a) * b"}, {name = "z", formula = "abs(a - 0.7)"}])toml",
                                      "b.toml");
  const GumResult found = gum(budget);
  EXPECT_NEAR(found.sensitivity(0, 0) / (std::exp(0.7) * 3e6), 1.0, 1e-7);
  EXPECT_NEAR(found.sensitivity(0, 1) / std::exp(0.7), 1.0, 1e-7);
  EXPECT_NEAR(found.sensitivity(1, 0), 0.0, 1e-9) << "no slope where the formula has a corner";
}

}  // namespace
}  // namespace thermotwin::metrology
