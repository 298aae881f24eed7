// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/monte_carlo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::metrology {
namespace {

Budget budget_of(const char* name) {
  return Budget::load(std::string(THERMOTWIN_SOURCE_DIR) + "/cases/budgets/" + name);
}

// JCGM 101:2008, tables 3 and 4: +-3.88 beside +-3.92 of the law of propagation, +-17.0 beside +-19.9.
TEST(MonteCarlo, RectangularInputsOfJcgm101) {
  Budget budget = budget_of("jcgm101_rectangular.toml");
  budget.draws = 300000;
  const GumResult linear = gum(budget);
  const MonteCarloResult drawn = monte_carlo(budget);
  EXPECT_NEAR(linear.expanded[0], 3.92, 5e-3);
  EXPECT_NEAR(drawn.symmetric[0].low, -3.88, 0.025);
  EXPECT_NEAR(drawn.symmetric[0].high, 3.88, 0.025);
  EXPECT_NEAR(drawn.std[0], 2.0, 5e-3);
  EXPECT_NEAR(linear.expanded[1], 19.9, 0.05);
  EXPECT_NEAR(drawn.symmetric[1].low, -17.0, 0.05);
  EXPECT_NEAR(drawn.symmetric[1].high, 17.0, 0.05);
  const Comparison alike = compare(budget, linear, drawn, 0), dominated = compare(budget, linear, drawn, 1);
  EXPECT_DOUBLE_EQ(alike.tolerance, 0.05);
  EXPECT_EQ(alike.agreement, Agreement::agree);
  EXPECT_DOUBLE_EQ(dominated.tolerance, 0.5);
  EXPECT_EQ(dominated.agreement, Agreement::disagree);
  EXPECT_NEAR(dominated.high_apart, 2.9, 0.1);
}

TEST(MonteCarlo, IsTheSameForAnyNumberOfThreads) {
  Budget budget = budget_of("jcgm100_h2.toml");
  budget.draws = 30000;
  core::set_thread_count(1);
  const MonteCarloResult one = monte_carlo(budget);
  core::set_thread_count(3);
  const MonteCarloResult three = monte_carlo(budget);
  core::set_thread_count(0);
  EXPECT_TRUE(one.draws == three.draws);
  budget.seed = 2;
  EXPECT_FALSE(monte_carlo(budget).draws == one.draws);
}

// A tolerance that the draws cannot resolve decides nothing.
TEST(MonteCarlo, TooFewDrawsDecideNothing) {
  Budget budget = budget_of("jcgm100_h2.toml");
  budget.draws = 20000;
  const Comparison compared = compare(budget, gum(budget), monte_carlo(budget), 0);
  EXPECT_FALSE(compared.enough_draws);
  EXPECT_NE(compared.agreement, Agreement::disagree);
}

// Readings that were taken together keep their correlation; five of them have the deviation of a t distribution.
TEST(MonteCarlo, ReadingsAreDrawnFromAJointTDistribution) {
  Budget budget = budget_of("jcgm100_h2.toml");
  budget.draws = 200000;
  const GumResult linear = gum(budget);
  const MonteCarloResult drawn = monte_carlo(budget);
  EXPECT_NEAR(drawn.correlation(1, 2), linear.correlation(1, 2), 0.003);
  EXPECT_NEAR(drawn.correlation(0, 1), linear.correlation(0, 1), 0.02);
  EXPECT_NEAR(drawn.std[2] / linear.std[2], std::sqrt(2.0), 0.03) << "variance n / (n - 2) with 4 degrees of freedom";
  EXPECT_NEAR((drawn.symmetric[2].high - drawn.symmetric[2].low) / (2.0 * linear.expanded[2]), 1.0, 0.02);
}

TEST(MonteCarlo, DistributionsHaveTheirMoments) {
  const Budget budget = Budget::parse(R"toml(schema = 1
monte_carlo.draws = 200000
input = [{name = "r", value = 1, distribution = "rectangular", half_width = 2},
         {name = "t", distribution = "triangular", half_width = 2},
         {name = "a", distribution = "arcsine", half_width = 2},
         {name = "n", std = 2}, {name = "q", distribution = "rectangular", half_width = 3}]
correlation = [{between = ["r", "q"], coefficient = 0.8}, {between = ["t", "n"], coefficient = -0.5}]
quantity = [{name = "R", formula = "r"}, {name = "T", formula = "t"}, {name = "A", formula = "a"},
            {name = "N", formula = "n"}, {name = "Q", formula = "q"}, {name = "skew", formula = "exp(r)"}])toml",
                                      "b.toml");
  const MonteCarloResult drawn = monte_carlo(budget);
  const double stds[] = {2.0 / std::sqrt(3.0), 2.0 / std::sqrt(6.0), 2.0 / std::sqrt(2.0), 2.0, 3.0 / std::sqrt(3.0)};
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(drawn.std[i] / stds[i], 1.0, 0.01) << i;
  EXPECT_NEAR(drawn.mean[0], 1.0, 0.01);
  EXPECT_NEAR(drawn.correlation(0, 4), 0.8, 0.005);
  EXPECT_NEAR(drawn.correlation(1, 3), -0.5, 0.02);
  EXPECT_GE(drawn.draws.col(0).minCoeff(), -1.0);
  EXPECT_LE(drawn.draws.col(0).maxCoeff(), 3.0);
  EXPECT_LT(drawn.shortest[5].high - drawn.shortest[5].low, 0.99 * (drawn.symmetric[5].high - drawn.symmetric[5].low));
}

// JCGM 101, 6.4.3.3: limits known within d widen a rectangle of half width w to the variance w^2 / 3 + d^2 / 9.
TEST(MonteCarlo, LimitsThatAreKnownInexactlyWidenTheDraws) {
  for (const double degrees : {2.0, 50.0}) {
    const Budget budget = Budget::parse(
        "schema = 1\ninput = [{name = \"x\", distribution = \"rectangular\", half_width = 3, degrees_of_freedom = " +
            std::to_string(degrees) + "}]\nquantity = [{name = \"y\", formula = \"x\"}]",
        "b.toml");
    const double d = 3.0 * std::sqrt(1.5 / degrees), expected = std::sqrt(3.0 + d * d / 9.0);
    EXPECT_NEAR(monte_carlo(budget).std[0], expected, 0.002 * expected) << degrees;
  }
  EXPECT_THROW(Budget::parse("schema = 1\ninput = [{name = \"x\", distribution = \"arcsine\", half_width = 3, "
                             "degrees_of_freedom = 1.2}]\nquantity = [{name = \"y\", formula = \"x\"}]",
                             "b.toml"),
               core::InputError);
}

// Two contributions that cancel leave rounding, in which both methods differ.
TEST(MonteCarlo, RoundingIsNoDisagreement) {
  const Budget budget = Budget::parse(
      "schema = 1\ninput = [{name = \"a\", value = 0, std = 1}, {name = \"b\", value = 1, std = 0.1}]\ncorrelation = "
      "[{between = [\"a\", \"b\"], coefficient = 1}]\nquantity = [{name = \"y\", formula = \"a - 10 * b\"}]\n",
      "b.toml");
  const Comparison compared = compare(budget, gum(budget), monte_carlo(budget), 0);
  EXPECT_EQ(compared.agreement, Agreement::agree);
  EXPECT_LT(compared.tolerance, 1e-11);
  EXPECT_TRUE(compared.enough_draws);
}

TEST(MonteCarlo, ToleranceIsHalfAUnitOfTheLastDigit) {
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.0347, 2), 0.0005);
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.0347, 1), 0.005);
  EXPECT_DOUBLE_EQ(numerical_tolerance(0.998, 2), 0.05) << "stated as 1.0";
  EXPECT_EQ(numerical_tolerance(0.0, 2), 0.0);
}

TEST(MonteCarlo, FormulasThatAreNotDefinedEverywhereAreRefused) {
  const Budget budget = Budget::parse(
      "schema = 1\ninput = [{name = \"a\", value = 1, std = 1}]\nquantity = [{name = \"y\", formula = \"sqrt(a + "
      "0.5)\"}]\nmonte_carlo.draws = 10000\n",
      "b.toml");
  try {
    monte_carlo(budget);
    ADD_FAILURE();
  } catch (const core::InputError& error) {
    for (const char* word : {"quantity[1]", "of 10000 draws", "defined for all values"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

// Two inputs that cancel: a correlation of -1 leaves rounding alone, and both methods agree.
TEST(MonteCarlo, InputsThatCancelAgree) {
  Budget budget = Budget::parse(
      "schema = 1\nsimultaneous = ['x', 'y', 'z']\n[[input]]\nname = 'x'\nreadings = [1, 2]\n[[input]]\nname = 'y'\n"
      "readings = [2, 1]\n[[input]]\nname = 'z'\nreadings = [3, 7]\n[[quantity]]\nname = 'q'\nformula = 'x+y'\n",
      "budget.toml");
  budget.draws = 20000;
  EXPECT_EQ(compare(budget, gum(budget), monte_carlo(budget), 0).agreement, Agreement::agree);
}

TEST(MonteCarlo, FewDrawsHaveADeviationOfTheirEnds) {
  Budget budget = budget_of("jcgm101_rectangular.toml");
  double squares = 0.0, stated = 0.0, mean = 0.0;
  for (int seed = 1; seed <= 30; ++seed) {
    budget.seed = seed;
    budget.draws = 10000;
    const MonteCarloResult drawn = monte_carlo(budget);
    mean += drawn.symmetric[0].high / 30.0;
    squares += drawn.symmetric[0].high * drawn.symmetric[0].high / 30.0;
    stated += drawn.end_std[0] / 30.0;
  }
  const double ratio = stated / std::sqrt(squares - mean * mean);
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.8);
}

// A correlated input keeps its own degrees of freedom, and no draw decides within the scatter of its ends.
TEST(MonteCarlo, CorrelatedInputsKeepTheirDegreesOfFreedom) {
  const Budget budget = Budget::parse(R"toml(schema = 1
monte_carlo.draws = 400000
input = [{name = "a", std = 1, degrees_of_freedom = 4}, {name = "b", std = 1, degrees_of_freedom = 30}]
correlation = [{between = ["a", "b"], coefficient = 0.1}]
quantity = [{name = "y", formula = "b"}])toml",
                                      "b.toml");
  const MonteCarloResult drawn = monte_carlo(budget);
  EXPECT_NEAR(drawn.std[0], std::sqrt(30.0 / 28.0), 0.01);
  EXPECT_NEAR(drawn.symmetric[0].high, 2.042, 0.03) << "t(30), 95 %";
}

TEST(MonteCarlo, NearTheToleranceNothingIsDecided) {
  Budget budget = budget_of("jcgm101_rectangular.toml");
  const GumResult linear = gum(budget);
  MonteCarloResult drawn = monte_carlo(budget);
  drawn.end_std[0] = 0.2 * compare(budget, linear, drawn, 0).tolerance;
  const auto at = [&](double tolerances) {
    const double tolerance = compare(budget, linear, drawn, 0).tolerance;
    drawn.symmetric[0] = {linear.value[0] - linear.expanded[0], linear.value[0] + linear.expanded[0]};
    drawn.symmetric[0].high += tolerances * tolerance;
    return compare(budget, linear, drawn, 0).agreement;
  };
  EXPECT_EQ(at(0.5), Agreement::agree);
  EXPECT_EQ(at(0.7), Agreement::agree);
  EXPECT_EQ(at(0.9), Agreement::undecided);
  EXPECT_EQ(at(1.3), Agreement::undecided);
  EXPECT_EQ(at(1.5), Agreement::disagree);
}

}  // namespace
}  // namespace thermotwin::metrology
