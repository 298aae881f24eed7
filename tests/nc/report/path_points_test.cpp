// SPDX-License-Identifier: GPL-3.0-or-later
// What a thinned path leaves out is as near to it as it states, in place and in error.
#include "nc/report/path_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace thermotwin::nc {
namespace {

/// A spiral with an error that ripples; every 500th move is rapid.
std::vector<PathPoint> spiral(int count) {
  std::vector<PathPoint> points;
  for (int i = 0; i < count; ++i) {
    const double t = 0.02 * i, r = 0.01 + 2e-6 * i;
    PathPoint point;
    point.place = {r * std::cos(t), r * std::sin(t), 1e-7 * i};
    point.error_um = {5.0 * std::sin(0.3 * t), 1e-3 * i, 2.0};
    point.std_um = Eigen::Vector3d::Ones();
    point.time = 0.1 * i;
    point.line = static_cast<std::uint32_t>(i);
    point.rapid = i % 500 == 0;
    points.push_back(point);
  }
  return points;
}

/// Largest distances of the given points from the kept path: m and um. Both are in the program's order.
Eigen::Vector2d apart(const std::vector<PathPoint>& given, const std::vector<PathPoint>& kept) {
  Eigen::Vector2d most = Eigen::Vector2d::Zero();
  std::size_t at = 0;
  for (const PathPoint& point : given) {
    while (at + 2 < kept.size() && kept[at + 1].line < point.line) ++at;
    const PathPoint &a = kept[at], &b = kept[at + 1];
    const Eigen::Vector3d chord = b.place - a.place;
    const double share = std::clamp(chord.dot(point.place - a.place) / chord.squaredNorm(), 0.0, 1.0);
    most[0] = std::max(most[0], (a.place + share * chord - point.place).norm());
    most[1] = std::max(most[1], (a.error_um + share * (b.error_um - a.error_um) - point.error_um).norm());
  }
  return most;
}

PathPoints thinned(const std::vector<PathPoint>& given, const PathPoints::Options& options) {
  PathPoints path(options);
  for (const PathPoint& point : given) path.add(point);
  path.finish();
  return path;
}

TEST(PathPoints, WhatIsLeftOutLiesWithinTheTolerances) {
  const std::vector<PathPoint> given = spiral(20000);
  const PathPoints path = thinned(given, {});
  EXPECT_LT(path.points().size(), 3 * given.size() / 5);
  EXPECT_EQ(path.given(), 20000);
  EXPECT_DOUBLE_EQ(path.place_tolerance(), 1e-5);
  const Eigen::Vector2d most = apart(given, path.points());
  EXPECT_LE(most[0], path.place_tolerance() * (1 + 1e-9));
  EXPECT_LE(most[1], path.error_tolerance_um() * (1 + 1e-9));
  EXPECT_GT(std::max(most[0] / path.place_tolerance(), most[1] / path.error_tolerance_um()), 0.5)
      << "nothing is thinned";
  EXPECT_EQ(path.points().front().line, 0U);
  EXPECT_EQ(path.points().back().line, 19999U);
}

TEST(PathPoints, TolerancesGrowUntilThePointsAreFew) {
  const std::vector<PathPoint> given = spiral(200000);
  const PathPoints path = thinned(given, {1000, 1e-5, 0.05});
  EXPECT_LE(path.points().size(), 1000U);
  EXPECT_GT(path.points().size(), 50U);
  EXPECT_GT(path.place_tolerance(), 1e-5);
  const Eigen::Vector2d most = apart(given, path.points());
  EXPECT_LE(most[0], path.place_tolerance());
  EXPECT_LE(most[1], path.error_tolerance_um());
}

// A rapid move over a straight line stays one.
TEST(PathPoints, RapidAndFeedStretchesStayApart) {
  std::vector<PathPoint> given;
  for (int i = 0; i < 300; ++i) {
    PathPoint point;
    point.place = {1e-3 * i, 0, 0};
    point.error_um = point.std_um = Eigen::Vector3d::Zero();
    point.line = static_cast<std::uint32_t>(i);
    point.rapid = i >= 100 && i < 200;
    given.push_back(point);
  }
  const PathPoints path = thinned(given, {});
  ASSERT_EQ(path.points().size(), 4U);
  EXPECT_EQ(path.points()[1].line, 99U);
  EXPECT_FALSE(path.points()[1].rapid);
  EXPECT_EQ(path.points()[2].line, 199U);
  EXPECT_TRUE(path.points()[2].rapid);
  EXPECT_FALSE(path.points()[3].rapid);
}

}  // namespace
}  // namespace thermotwin::nc
