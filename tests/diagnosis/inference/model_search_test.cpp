// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/model_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnosis/inference/switch_times.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;

/// Most second causes show nothing: what a pair gains over the strong cause in it, in the middle of all pairs that were
/// not fitted.
TEST(ModelSearch, WhatAStrongCauseGainsAboutItselfIsNoSecondOnes) {
  for (const double power : {3.0, 6.0}) {
    const diagnosis::Seen seen =
        diagnosis::see(lumped::coarse_model(),
                       lumped::measure({{lumped::find(Kind::source_power, "motor"), power}}, {.hours = 18}), {});
    const diagnosis::SearchResult found =
        diagnosis::search(seen.problem, *seen.response, lumped::coarse_model().machine);
    const auto leading = std::find_if(found.hypotheses.begin(), found.hypotheses.end(),
                                      [](const auto& h) { return h.members.size() == 1; });
    ASSERT_NE(leading, found.hypotheses.end());
    std::vector<double> gains;
    for (const diagnosis::Hypothesis& h : found.hypotheses) {
      if (h.members.size() == 2 && !h.refined && h.members[0] == leading->members[0])
        gains.push_back(h.log_evidence - leading->log_evidence);
    }
    ASSERT_GT(gains.size(), 10U);
    std::nth_element(gains.begin(), gains.begin() + static_cast<long>(gains.size() / 2), gains.end());
    // Room that is not needed costs a little, and not more.
    const double median = gains[gains.size() / 2];
    EXPECT_LT(median, 0.0) << power << ", evidence " << leading->log_evidence;
    EXPECT_GT(median, -4.0) << power;
  }
}

/// None, two single causes and both together, of such log evidences.
diagnosis::SearchResult shared(double first, double second, double both, double log_odds_unknown) {
  diagnosis::SearchResult found;
  found.hypotheses.resize(4);
  found.hypotheses[1].members = {0};
  found.hypotheses[2].members = {1};
  found.hypotheses[3].members = {0, 1};
  const double priors[] = {0.5, 0.02, 0.02, 0.002}, evidences[] = {0.0, first, second, both};
  for (std::size_t i = 0; i < 4; ++i) {
    found.hypotheses[i].log_prior = std::log(priors[i]);
    found.hypotheses[i].log_evidence = evidences[i];
  }
  found.marginal = Eigen::VectorXd::Zero(2);
  found.log_odds_unknown = log_odds_unknown;
  diagnosis::share_probability(found);
  return found;
}

TEST(ModelSearch, BesideSomethingUnknownWhatACauseGainsCountsByWhatItLeaves) {
  const diagnosis::SearchResult listed = shared(300.0, 280.0, 299.0, -6.0);
  EXPECT_GT(listed.marginal[0], 0.99);
  EXPECT_LT(listed.probability_unknown, 0.01);
  EXPECT_DOUBLE_EQ(listed.misfit, 0.0);
  // Something unknown that is much less than the cause: it stays sure, its rival of much less evidence unlikely.
  const diagnosis::SearchResult little = shared(300.0, 100.0, 299.0, 10.0);
  EXPECT_NEAR(little.misfit, 10.0 - std::log(0.1), 1e-12);
  EXPECT_GT(little.marginal[0], 0.95);
  EXPECT_LT(little.marginal[1], 0.1);
  EXPECT_GT(little.probability_unknown, 0.999);
  EXPECT_GT(little.probability_leftover, 0.95);
  // As much as the cause: neither that one nor a rival is likely, though their evidences are far apart.
  const diagnosis::SearchResult much = shared(300.0, 200.0, 299.0, 200.0);
  EXPECT_LT(much.marginal[0], 0.3);
  EXPECT_GT(much.marginal[1], 0.02);
  EXPECT_GT(much.marginal[0], much.marginal[1]);
  EXPECT_LT(much.probability_leftover, 0.5);
}

TEST(ModelSearch, AChannelThatIsOffAloneLeavesWhatTheOthersSay) {
  diagnosis::SearchResult one = shared(300.0, 200.0, 299.0, 200.0);
  ASSERT_LT(one.marginal[0], 0.3) << "several channels";
  one.beside_channels = {3};
  diagnosis::share_probability(one);
  EXPECT_DOUBLE_EQ(one.misfit, 0.0);
  EXPECT_GT(one.marginal[0], 0.99);
  EXPECT_GT(one.probability_unknown, 0.999);
  EXPECT_GT(one.probability_leftover, 0.99);
  // Held-out data of the others may still say that it is wrong.
  diagnosis::raise_misfit(one, 250.0);
  EXPECT_LT(one.marginal[0], 0.3);
}

TEST(ModelSearch, AMisfitThatIsFoundLaterSharesAnew) {
  diagnosis::SearchResult found = shared(300.0, 280.0, 299.0, -6.0);
  diagnosis::raise_misfit(found, 3.0);
  EXPECT_NEAR(found.misfit, 3.0, 1e-12);
  EXPECT_NEAR(found.probability_unknown, 0.67, 0.01);
  EXPECT_GT(found.marginal[0], 0.97);
  diagnosis::raise_misfit(found, 250.0);
  EXPECT_LT(found.marginal[0], 0.3);
  const double unknown = found.probability_unknown;
  diagnosis::raise_misfit(found, 5.0);
  EXPECT_DOUBLE_EQ(found.probability_unknown, unknown);
}

}  // namespace
