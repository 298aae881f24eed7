// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/stations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::metrology {
namespace {

using compensation::test::five_axis_machine;

std::vector<PlannedPoint> sweep(double from_deg, double to_deg, int count) {
  std::vector<PlannedPoint> points(count);
  for (int i = 0; i < count; ++i) {
    points[i].pose = Eigen::VectorXd::Zero(5);
    points[i].pose[3] = core::units::deg * (from_deg + (to_deg - from_deg) * i / (count - 1));
  }
  return points;
}

TEST(Stations, ADiscreteTestHasOneForEachPose) {
  const mesh::Machine machine = five_axis_machine();
  std::vector<PlannedPoint> points(5);
  for (int i = 0; i < 5; ++i) {
    points[i].pose = Eigen::VectorXd::Zero(5);
    points[i].pose[4] = 0.5 * std::numbers::pi * i;
  }
  const Stations stations = stations_of(machine, points);
  EXPECT_EQ(stations.poses.size(), 4u);  // a turn further is the same place
  EXPECT_EQ(stations.of_point[4].front().first, stations.of_point[0].front().first);
}

TEST(Stations, ASweepIsInterpolated) {
  const mesh::Machine machine = five_axis_machine();
  const std::vector<PlannedPoint> points = sweep(-70, 60, 1301);
  const Stations stations = stations_of(machine, points);
  EXPECT_EQ(stations.poses.size(), 27u);
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double value = 0, sum = 0;
    for (const auto& [station, weight] : stations.of_point[i]) {
      value += weight * std::sin(stations.poses[station][3]);
      sum += weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    largest = std::max(largest, std::abs(value - std::sin(points[i].pose[3])));
  }
  EXPECT_LT(largest, 3e-6);  // the error of cubic interpolation, 3/128 (5 deg)^4 inside and more at the ends
}

TEST(Stations, ManyPosesOfTwoAxesAreRefused) {
  std::vector<PlannedPoint> points = sweep(-70, 60, 200);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].pose[4] = 0.01 * static_cast<double>(i);
  EXPECT_THROW(stations_of(five_axis_machine(), points), core::InputError);
}

}  // namespace
}  // namespace thermotwin::metrology
