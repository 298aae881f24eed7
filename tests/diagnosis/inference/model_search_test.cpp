// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/model_search.h"

#include <gtest/gtest.h>

#include <algorithm>
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

}  // namespace
