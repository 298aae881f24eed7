// SPDX-License-Identifier: GPL-3.0-or-later
// A table that turns in warm air: the faster, the warmer it gets, also where its film becomes turbulent.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

TEST(DiscFilm, NeverFallsWhileTheSpeedRises) {
  const Toy toy;
  toy.edit("machine.toml", "radius_mm = 75\n", "radius_mm = 400\n");  // transition: 250 to 308 rpm
  toy.edit("machine.toml", "at = [0, 36000], power_W = [0, 100]", "at = [0, 36000], power_W = [0, 0]");
  toy.edit("machine.toml", "[tcp]\n",
           "[[sensor]]\nid = \"table\"\nbody = \"table\"\npoint_mm = [40, 0, -5]\n\n[tcp]\n");
  toy.edit("machine.toml", "rapid_deg_min = 36000", "rapid_deg_min = 360000");
  double slower = 0.0;
  for (const int speed : {180, 235, 265, 280, 295, 320, 400}) {
    toy.write(
        "loads/warm.toml",
        fmt::format(
            "schema = 1\ntitle = \"table at {} rpm in warm air\"\ninitial_C = 20\ntime_step_s = 120\noutput_s = 1200\n"
            "[[phase]]\nduration_h = 0.33333333333333\nair_C = 40\n[[phase.axis]]\nid = \"C\"\nspeed_rpm = {}\n",
            speed, speed));
    const Result result = toy.run({"simulate", toy.path(), "--load", "warm", "--size", "coarse"});
    ASSERT_EQ(result.status, 0) << result.err;
    const auto reading = core::read_csv(toy.result("simulate/warm/sensors.csv")).column("table_C");
    EXPECT_GT(reading.tail(1)[0], slower) << speed << " rpm";
    slower = reading.tail(1)[0];
  }
}

}  // namespace
}  // namespace thermotwin::cases
