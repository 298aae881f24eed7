// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/range.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"

namespace thermotwin::core {
namespace {

TEST(Range, BoundsAreInclusiveAndNumbersFinite) {
  const Range range{1.0, 2.0};
  EXPECT_TRUE(range.holds(1.0) && range.holds(2.0));
  EXPECT_FALSE(range.holds(0.999) || range.holds(2.001));
  for (const Range& each : {range, any_number, positive, non_negative}) {
    EXPECT_FALSE(each.holds(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_FALSE(each.holds(std::numeric_limits<double>::infinity()));
  }
  EXPECT_TRUE(non_negative.holds(0.0));
  EXPECT_FALSE(positive.holds(0.0));
}

TEST(Range, ComplaintNamesFieldValueAndRange) {
  EXPECT_NO_THROW(require_within("refine", 1.0, positive));
  try {
    require_within("refine", -3.5, positive);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "refine: -3.5; allowed: a number above 0");
  }
}

TEST(Range, BoundsAreWrittenWithoutTheSlackOfRounding) {
  EXPECT_EQ(phrase({-60.0000002, 120.0000003}), "a number from -60 to 120");
  EXPECT_EQ(phrase({-1e-7, 1e-7}), "a number from 0 to 1e-07");
  EXPECT_EQ(phrase({0.00012, 1.5e-5}), "a number from 0.00012 to 1.5e-05");
  EXPECT_EQ(phrase({0.0, 8000.0 * (1.0 + 1e-9)}), "a number from 0 to 8000");
  EXPECT_EQ(phrase({0.0, 0.35}), "a number from 0 to 0.35");
}

}  // namespace
}  // namespace thermotwin::core
