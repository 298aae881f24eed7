// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/channel.h"

#include <gtest/gtest.h>

namespace {

using namespace thermotwin::compensation;

TEST(Channel, IsWhatItsNameSays) {
  const Channel spindle = channel_named("spindle.speed_rpm"), feed = channel_named("axis.X.feed_mm_min"),
                turn = channel_named("axis.C.position_deg"), low = channel_named("axis.X.2.low_mm"),
                power = channel_named("axis.X.power_W"), air = channel_named("air.T_C"),
                state = channel_named("cutting_fluid.on"), gradient = channel_named("air.gradient_K_m");
  EXPECT_EQ(spindle.quantity, Quantity::turning);
  EXPECT_EQ(spindle.axis, "");
  EXPECT_TRUE(spindle.is_speed() && feed.is_speed());
  EXPECT_EQ(feed.axis, "X");
  EXPECT_EQ(feed.unit, "mm_min");
  EXPECT_EQ(turn.quantity, Quantity::position);
  EXPECT_EQ(turn.unit, "deg");
  EXPECT_EQ(low.quantity, Quantity::range);
  EXPECT_EQ(low.axis, "X.2") << "ids may hold dots";
  EXPECT_EQ(power.quantity, Quantity::power);
  EXPECT_EQ(power.axis, "X");
  EXPECT_EQ(air.kind, ChannelKind::temperature);
  EXPECT_EQ(state.quantity, Quantity::state);
  EXPECT_EQ(gradient.quantity, Quantity::gradient);
  EXPECT_EQ(gradient.unit, "K/m") << "not limited to 0 to 1, as a state is";
}

}  // namespace
