// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/load/rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

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

// A motor that holds an axis against friction asks for the direction of the last motion.
TEST(Rows, KnowTheDirectionOfTheLastMotion) {
  ProcessHeat none;
  std::vector<Positions> positive;
  RowBuilder builder(Positions::Zero(2), 10.0, none, [&](const Row& row) { positive.push_back(row.positive); });
  double start = 0.0;
  const auto move = [&](double from, double to, double seconds) {
    Timed timed;
    timed.element = Element::line(Eigen::Vector2d(from, 0.0), Eigen::Vector2d(to, 0.0));
    timed.start = start;
    timed.t_cruise = seconds;
    start += seconds;
    builder.add(timed);
  };
  const auto wait = [&](double at, double seconds) {
    Timed timed;
    timed.element = Element::line(Eigen::Vector2d(at, 0.0), Eigen::Vector2d(at, 0.0));
    timed.element.pause = timed.t_cruise = seconds;
    timed.start = start;
    start += seconds;
    builder.add(timed);
  };
  wait(0.0, 10.0);
  move(0.0, 1.0, 2.5);
  wait(1.0, 5.0);
  move(1.0, 0.5, 2.5);
  wait(0.5, 10.0);
  builder.finish();
  ASSERT_EQ(positive.size(), 3u);
  EXPECT_NEAR(positive[0][0], 0.5, 1e-12) << "nothing moved";
  EXPECT_NEAR(positive[1][0], 0.75, 1e-12);
  EXPECT_NEAR(positive[2][0], 0.0, 1e-12);
  for (const Positions& row : positive) EXPECT_NEAR(row[1], 0.5, 1e-12) << "it never moved";
}

}  // namespace
}  // namespace thermotwin::nc
