// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"
#include "metrology/budget/budget_keys.h"
#include "tests/core/reference_page.h"

namespace thermotwin::metrology {
namespace {

const std::string head = "schema = 1\n[[input]]\nname = \"a\"\nstd = 1\nvalue = 2\n[[input]]\nname = \"b\"\nstd = 1\n";
const std::string sum = "[[quantity]]\nname = \"y\"\nformula = \"a + b\"\n";

void refused(const std::string& text, const std::vector<std::string>& words) {
  try {
    Budget::parse(text, "budget.toml");
    ADD_FAILURE() << "accepted:\n" << text;
  } catch (const core::InputError& error) {
    EXPECT_EQ(error.exit_status(), 3);
    for (const std::string& word : words)
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in: " << error.what();
  }
}

TEST(Budget, ReadsInputsAndMeasurands) {
  const Budget budget =
      Budget::parse(head + sum + "[[quantity]]\nname = \"z\"\nformula = \"2 * y - (a > 1 ? pi : 0)\"\n", "budget.toml");
  ASSERT_EQ(budget.inputs.size(), 2U);
  const Eigen::VectorXd values = Budget::Model(budget)(Eigen::Vector2d(2.0, 5.0));
  EXPECT_DOUBLE_EQ(values[0], 7.0);
  EXPECT_DOUBLE_EQ(values[1], 14.0 - 3.14159265358979323846);
}

TEST(Budget, ReadingsBecomeMeanAndDeviationOfTheMean) {
  const Budget budget = Budget::parse(
      "schema = 1\n[[input]]\nname = \"a\"\nreadings = [1, 2, 3, 6]\n[[quantity]]\nname = \"y\"\nformula = \"a\"\n",
      "budget.toml");
  EXPECT_DOUBLE_EQ(budget.inputs[0].value, 3.0);
  EXPECT_DOUBLE_EQ(budget.inputs[0].std, std::sqrt(14.0 / 3.0 / 4.0));
  EXPECT_EQ(budget.inputs[0].degrees_of_freedom, 3.0);
}

TEST(Budget, SlipsAreNamedWithPlaceValueAndWhatIsAllowed) {
  refused("schema = 1\n[[input]]\nname = \"a\"\nstd = -0.1\n", {"budget.toml:4", "input[1].std", "-0.1", "at least 0"});
  refused(head + "[[quantity]]\nname = \"y\"\nformula = \"a + bb\"\n", {"budget.toml:11", "'bb'", "nearest: b"});
  refused(head + "[[correlation]]\nbetween = [\"a\", \"c\"]\ncoefficient = 0.1\n" + sum, {"'c'", "inputs: a, b"});
  refused(head + "[[correlation]]\nbetween = [\"a\", \"b\"]\ncoefficient = 1.5\n" + sum,
          {"coefficient", "1.5", "-1 to 1"});
  refused(head + "[[input]]\nname = \"a\"\nstd = 1\n" + sum, {"'a' a second time"});
  refused(head + "[[input]]\nname = \"sin\"\nstd = 1\n" + sum, {"'sin'", "no name of a function"});
  refused(head + "[[quantity]]\nname = \"y\"\nformula = \"a = 3\"\n", {"'='", "no assignment"});
  refused(head + "[[quantity]]\nname = \"y\"\nformula = \"a, b\"\n", {"2 values"});
  refused(head + "[[quantity]]\nname = \"y\"\nformula = \"sqrt(-a)\"\n", {"quantity[1].formula", "finite"});
  refused(head + "[[quantity]]\nname = \"y\"\nformula = \"(a\"\n", {"quantity[1].formula", "(a"});
  refused(head, {"0 of them", "1 to 50"});
  refused("schema = 1\n" + sum, {"0 of them", "1 to 200"});
  refused(head + sum + "[monte_carlo]\ndraws = 7\n", {"draws", "7", "10000"});
  refused(head + sum + "probability = 0.9\n", {"probability"});
  refused("schema = 1\n[[input]]\nname = \"a\"\nreadings = [1]\n" + sum, {"1 readings", "at least 2"});
  refused("schema = 1\n[[input]]\nname = \"a\"\nreadings = [1, 2]\nstd = 1\n" + sum, {"beside readings"});
  refused(
      "schema = 1\nsimultaneous = [\"a\", \"b\"]\n[[input]]\nname = \"a\"\nreadings = [1, 2]\n[[input]]\nname = "
      "\"b\"\nreadings = [1, 2, 3]\n" +
          sum,
      {"3 readings of 'b'", "as many as 'a'"});
}

TEST(Budget, CorrelationsWithANegativeVarianceAreRefused) {
  const std::string three = head + "[[input]]\nname = \"c\"\nstd = 1\n";
  const auto pair = [](const char* a, const char* b, const char* r) {
    return std::string("[[correlation]]\nbetween = [\"") + a + "\", \"" + b + "\"]\ncoefficient = " + r + "\n";
  };
  refused(three + pair("a", "b", "0.9") + pair("b", "c", "0.9") + pair("a", "c", "-0.9") + sum,
          {"correlation", "negative variance", "-0.8", "eigenvalue"});
  EXPECT_NO_THROW(
      Budget::parse(three + pair("a", "b", "0.9") + pair("b", "c", "0.9") + pair("a", "c", "0.9") + sum, "b.toml"));
}

TEST(Budget, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("budget", budget_keys(), "metrology_tests");
}

}  // namespace
}  // namespace thermotwin::metrology
