// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/linuxcnc/hal_config.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/compensation/linuxcnc/mill.h"

namespace thermotwin::compensation {
namespace {

TEST(HalConfig, KnowsAxesSignalsAndTheThread) {
  const test::Mill mill;
  const HalConfig config = read_hal_config(mill.ini(), mill.library());
  EXPECT_EQ(config.kinematics, "trivkins");
  EXPECT_EQ(config.thread, "fast-thread");
  ASSERT_NE(config.axis('Y'), nullptr);
  EXPECT_EQ(config.axis('Y')->joint, 1);
  EXPECT_EQ(config.axis('Z')->joint, 3) << "Y has two joints";
  EXPECT_EQ(config.axis('X')->fastest, 200.0);
  EXPECT_FALSE(config.axis('X')->has_offsets);
  EXPECT_TRUE(config.axis('Z')->has_offsets);
  EXPECT_EQ(config.axis('B'), nullptr);
  EXPECT_EQ(config.mm_per_unit, 25.4);
  EXPECT_EQ(config.signal_of_pin.at("joint.0.pos-cmd"), "X-here");
  EXPECT_EQ(config.signal_of_pin.at("spindle.0.speed-out-abs"), "speed") << "over two lines, and with [SECTION]KEY";
  EXPECT_EQ(config.signal_of_pin.at("motion.motion-enabled"), "is-on") << "linkps, in a file of the library";
  EXPECT_NE(config.place_of_pin.at("joint.0.pos-cmd").find("mill.hal:2"), std::string::npos);
  EXPECT_EQ(config.components, (std::vector<std::string>{"one", "two", "panel"}));
  EXPECT_EQ(config.unread.size(), 2U) << "a Tcl file, and one that is not there";
}

TEST(HalConfig, RefusesWhatIsNoConfiguration) {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& named) {
    const test::Mill mill(from, to);
    try {
      read_hal_config(mill.ini(), mill.library());
      ADD_FAILURE() << to << " was taken";
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
  };
  refused("KINEMATICS = trivkins coordinates=XYYZ", "", "[KINS]KINEMATICS");
  refused("LINEAR_UNITS = inch", "LINEAR_UNITS = furlong", "mill.ini:6 [TRAJ]LINEAR_UNITS: 'furlong'");
  refused("MAX_VELOCITY = 200", "MAX_VELOCITY = fast", "[AXIS_X]MAX_VELOCITY: 'fast'");
  refused("coordinates=XYYZ", "coordinates=XYQ", "'XYQ'");
  refused("[TRAJ]", "[TRAJ", "mill.ini:5");
  refused("MAX_VELOCITY = 200", "MAX_VELOCITY 200", "KEY = VALUE");
  EXPECT_THROW(read_hal_config("/no/such.ini"), core::InputError);
}

}  // namespace
}  // namespace thermotwin::compensation
