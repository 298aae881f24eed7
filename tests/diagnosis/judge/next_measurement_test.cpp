// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/next_measurement.h"

#include <gtest/gtest.h>

#include <limits>

#include "diagnosis/record/observations.h"

namespace {

using namespace thermotwin;
using diagnosis::Observations;

/// Two phases of a speed in equal steps, and an input that nobody states.
Observations load(double start, double hours, double speed, int steps) {
  Observations all;
  all.start = start;
  all.end = start + 3600.0 * hours;
  all.points = Eigen::VectorXd::LinSpaced(steps + 1, all.start, all.end);
  all.rows.setConstant(steps, 2, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < steps; ++i) all.rows(i, 0) = 2 * i < steps ? speed : 0.0;
  return all;
}

TEST(NextMeasurement, TheLoadOfTheRecordIsKnownAgain) {
  const Observations record = load(100.0, 24.0, 5000.0, 288);
  EXPECT_TRUE(repeats(load(0.0, 24.0, 5000.0, 48), record)) << "in longer steps, from another time on";
  EXPECT_TRUE(repeats(load(0.0, 24.0, 5100.0, 48), record));
  EXPECT_FALSE(repeats(load(0.0, 24.0, 8000.0, 48), record)) << "another speed";
  EXPECT_FALSE(repeats(load(0.0, 12.0, 5000.0, 48), record)) << "half as long";
}

}  // namespace
