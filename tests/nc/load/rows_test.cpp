// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/load/rows.h"

#include <gtest/gtest.h>

namespace thermotwin::nc {
namespace {

// load.toml states the mean speed, and a machine refuses one above its largest.
TEST(Rows, NoMeanSpeedIsAboveTheLargestOne) {
  ProcessHeat none;
  int rows = 0;
  RowBuilder builder(Positions::Zero(1), 10.0, none, [&](const Row& row) {
    ++rows;
    EXPECT_LE(row.spindle_rpm, 12000.0) << rows;
    EXPECT_NEAR(row.spindle_rpm, 12000.0, 1e-6);
  });
  Timed timed;
  timed.element = Element::line(Positions::Zero(1), Positions::Ones(1));
  timed.element.state.spindle_rpm = -12000.0;
  for (int i = 0; i < 5000; ++i) {
    timed.start = timed.end();
    timed.t_cruise = 0.1 + 0.037 * (i % 7);
    builder.add(timed);
  }
  builder.finish();
  EXPECT_GT(rows, 100);
}

}  // namespace
}  // namespace thermotwin::nc
