// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/svg.h"

#include <gtest/gtest.h>

#include <limits>

namespace thermotwin::core {
namespace {

TEST(Svg, TextIsMadeHarmless) {
  EXPECT_EQ(xml_text("a<b & \"c\">"), "a&lt;b &amp; &quot;c&quot;&gt;");
  EXPECT_EQ(xml_text(std::string("x\x01y\x00\tz\n", 7)), "xy\tz\n");
  EXPECT_EQ(xml_text("µm °C"), "µm °C");
}

TEST(Svg, TicksAreRoundAndInside) {
  EXPECT_EQ(axis_ticks(0.0, 10.0, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(axis_ticks(-1.2, 1.3, 5), (std::vector<double>{-1.0, -0.5, 0.0, 0.5, 1.0}));
  EXPECT_EQ(axis_ticks(0.0, 86.0, 8).size(), 5U) << "0, 20 .. 80";
  EXPECT_EQ(axis_ticks(1e5, 1.7e5, 8).size(), 8U) << "steps of 10,000";
}

TEST(Svg, NoTicksWithoutARange) {
  EXPECT_TRUE(axis_ticks(1.0, 1.0, 5).empty());
  EXPECT_TRUE(axis_ticks(2.0, 1.0, 5).empty());
  EXPECT_TRUE(axis_ticks(0.0, std::numeric_limits<double>::infinity(), 5).empty());
  EXPECT_TRUE(axis_ticks(std::numeric_limits<double>::quiet_NaN(), 1.0, 5).empty());
}

}  // namespace
}  // namespace thermotwin::core
