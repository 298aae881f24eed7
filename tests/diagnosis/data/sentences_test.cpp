// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/sentences.h"

#include <gtest/gtest.h>

namespace thermotwin::diagnosis {
namespace {

TEST(Sentences, AgreeWithTheNumberOfTheirSubjects) {
  EXPECT_EQ(
      doubt({"dx"}, 8.0, within_uncertainty(1), {}),
      "dx follows the lag model of the first 8 h within its uncertainty, but an unknown cause may have changed it.");
  EXPECT_EQ(doubt({"dx", "dz"}, 8.0, within_uncertainty(2), {"probe_drift of dx", "time_constant of dz"}),
            "dx, dz follow the lag model of the first 8 h within their uncertainty, but probe_drift of dx or "
            "time_constant of dz may have changed them.");
  EXPECT_EQ(explain_the_rest({}), "");
  EXPECT_EQ(explain_the_rest({"a"}), " a explains the rest.");
  EXPECT_EQ(explain_the_rest({"a", "b"}), " a, b explain the rest.");
  EXPECT_EQ(hold_in_the_last_part({}), "no proposed cause holds in the last part");
  EXPECT_EQ(hold_in_the_last_part({"a"}), "only a holds in the last part");
  EXPECT_EQ(hold_in_the_last_part({"a", "b"}), "only a, b hold in the last part");
}

}  // namespace
}  // namespace thermotwin::diagnosis
