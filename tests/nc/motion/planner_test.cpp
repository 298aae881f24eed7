// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace thermotwin::nc {
namespace {

Positions at(double x, double y) {
  Positions p(2);
  p << x, y;
  return p;
}

Element line(const Positions& from, const Positions& to, double speed) {
  Element element = Element::line(from, to);
  element.length = (to - from).norm();
  element.speed = speed;
  element.last = true;
  return element;
}

std::vector<Timed> plan(const std::vector<Element>& elements, int look_ahead, double tolerance = 2e-5,
                        double block_cycle = 0.0, bool overlaps = false) {
  std::vector<Timed> timed;
  Planner planner({{{1.0, 2.0}, {1.0, 2.0}}, tolerance, block_cycle, look_ahead, overlaps},
                  [&](const Timed& one) { timed.push_back(one); });
  for (const Element& element : elements) planner.push(element);
  planner.finish();
  return timed;
}

// A random zigzag: speeds are continuous, no limit is broken, every element is covered, whatever the look-ahead.
TEST(Planner, SpeedsAreContinuousAndWithinTheLimits) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> step(-0.01, 0.01);
  std::vector<Element> elements;
  Positions from = at(0, 0);
  for (int i = 0; i < 400; ++i) {
    const Positions to = from + at(step(random), step(random));
    elements.push_back(line(from, to, 0.1));
    from = to;
  }
  double shortest = 0.0;
  for (const int look_ahead : {1000, 20, 1}) {
    const std::vector<Timed> timed = plan(elements, look_ahead);
    ASSERT_EQ(timed.size(), elements.size());
    EXPECT_EQ(timed.front().v0, 0.0);
    EXPECT_EQ(timed.back().v1, 0.0);
    double time = 0.0;
    for (std::size_t i = 0; i < timed.size(); ++i) {
      const Timed& one = timed[i];
      EXPECT_NEAR(one.start, time, 1e-9);
      time += one.duration();
      EXPECT_DOUBLE_EQ(one.v0, i > 0 ? timed[i - 1].v1 : 0.0);
      EXPECT_LE(one.cruise, 0.1 + 1e-12);
      const Positions speed = one.element.slope / one.element.length;
      for (const double axis : speed) {
        EXPECT_LE(std::abs(axis) * one.cruise, 1.0 + 1e-9);
        EXPECT_LE(std::abs(axis) * (one.cruise - one.v0), (2.0 + 1e-9) * one.t_up + 1e-15);
        EXPECT_LE(std::abs(axis) * (one.cruise - one.v1), (2.0 + 1e-9) * one.t_down + 1e-15);
      }
      const double covered =
          0.5 * (one.v0 + one.cruise) * one.t_up + one.cruise * one.t_cruise + 0.5 * (one.cruise + one.v1) * one.t_down;
      EXPECT_NEAR(covered, one.element.length, 1e-9);
      EXPECT_NEAR(one.share_at(one.duration() * 0.999999), 1.0, 1e-4);
    }
    EXPECT_GE(time, shortest) << "less look-ahead is never faster";
    shortest = time;
  }
}

TEST(Planner, PausesStopTheAxes) {
  Element pause = Element::line(at(0.1, 0), at(0.1, 0));
  pause.pause = 3.0;
  const std::vector<Timed> timed =
      plan({line(at(0, 0), at(0.1, 0), 0.1), pause, line(at(0.1, 0), at(0.2, 0), 0.1)}, 10);
  EXPECT_EQ(timed[0].v1, 0.0);
  EXPECT_EQ(timed[2].v0, 0.0);
  EXPECT_NEAR(timed[2].start, 1.0 + 0.05 + 3.0, 1e-12);
}

// Exact path mode stops where a move ends, and rounds the corners within one.
TEST(Planner, ExactPathStopsAtTheEndsOfMoves) {
  std::vector<Element> elements = {line(at(0, 0), at(0.1, 0), 0.1), line(at(0.1, 0), at(0.2, 0.001), 0.1),
                                   line(at(0.2, 0.001), at(0.3, 0.003), 0.1)};
  for (Element& element : elements) element.path_mode = 2;
  elements[0].last = false;
  const std::vector<Timed> timed = plan(elements, 10);
  EXPECT_GT(timed[0].v1, 0.05);
  EXPECT_EQ(timed[1].v1, 0.0);
}

// Short segments of a circle are no faster than the circle: v^2 = a r, whatever the tolerance.
TEST(Planner, ManySegmentsOfACircleAreAsFastAsTheCircle) {
  const double radius = 0.002, turn = 0.02;
  std::vector<Element> elements;
  for (int i = 0; i < 600; ++i)
    elements.push_back(line(at(radius * std::cos(turn * i), radius * std::sin(turn * i)),
                            at(radius * std::cos(turn * (i + 1)), radius * std::sin(turn * (i + 1))), 1.0));
  const double bend = std::sqrt(2.0 * radius);
  for (const double tolerance : {1.0, 1e-3}) {
    const std::vector<Timed> timed = plan(elements, 1000, tolerance);
    for (std::size_t i = 100; i < 500; ++i) {
      EXPECT_LE(timed[i].v0, bend * std::sqrt(1.0 / std::cos(std::numbers::pi / 4)) * 1.001);
      EXPECT_GE(timed[i].v0, 0.95 * bend);
    }
  }
}

// Short sides of a staircase: each from rest to rest with a / 2, half of its time beside the next one.
TEST(Planner, AControlMayOverlapSharpCorners) {
  std::vector<Element> stairs;
  Positions from = at(0, 0);
  for (int i = 0; i < 60; ++i) {
    const Positions to = from + (i % 2 == 0 ? at(0.001, 0) : at(0, 0.001));
    stairs.push_back(line(from, to, 1.0));
    from = to;
  }
  const std::vector<Timed> timed = plan(stairs, 100, 1.0, 0.0, true);
  for (std::size_t i = 5; i < 55; ++i) EXPECT_NEAR(timed[i].duration(), std::sqrt(0.001 / 1.0), 1e-6);
  // Without a tolerance they hardly meet: almost the time from rest to rest.
  const std::vector<Timed> tight = plan(stairs, 100, 1e-9, 0.0, true);
  EXPECT_NEAR(tight[30].duration(), 2.0 * std::sqrt(0.001 / 1.0), 5e-3);
}

TEST(Planner, NoElementIsShorterThanTheBlockCycle) {
  std::vector<Element> pieces;
  for (int i = 0; i < 200; ++i) pieces.push_back(line(at(1e-5 * i, 0), at(1e-5 * (i + 1), 0), 0.1));
  const std::vector<Timed> timed = plan(pieces, 500, 2e-5, 2e-3);
  for (const Timed& one : timed) EXPECT_GE(one.duration(), 2e-3 * (1 - 1e-9));
  EXPECT_NEAR(timed.back().start + timed.back().duration(), 0.4, 0.01);
}

// Collinear pieces are as fast as the whole.
TEST(Planner, PiecesOfALineTakeTheTimeOfTheLine) {
  std::vector<Element> pieces;
  for (int i = 0; i < 50; ++i) pieces.push_back(line(at(0.002 * i, 0), at(0.002 * (i + 1), 0), 0.1));
  const std::vector<Timed> timed = plan(pieces, 100);
  EXPECT_NEAR(timed.back().start + timed.back().duration(), 1.0 + 0.05, 1e-9);
}

TEST(Element, SweepOfAnArcIsItsTravelAndRange) {
  // Three quarters of a circle of radius 2 about the origin from (2, 0), with a feed of the first axis by 1.
  Element arc = Element::line(at(0, 0), at(0, 0));
  arc.first = at(1, 0);
  arc.second = at(0, 1);
  arc.r0 = arc.r1 = 2;
  arc.angle = 1.5 * 3.14159265358979323846;
  Positions travel = at(0, 0), low = at(9, 9), high = at(-9, -9);
  arc.sweep(0, 1, travel, low, high);
  EXPECT_NEAR(travel[0], 6.0, 1e-12);
  EXPECT_NEAR(travel[1], 6.0, 1e-12);
  EXPECT_NEAR(low[0], -2.0, 1e-12);
  EXPECT_NEAR(high[1], 2.0, 1e-12);
  // In parts it is the same.
  Positions parts = at(0, 0);
  for (int i = 0; i < 7; ++i) arc.sweep(i / 7.0, (i + 1) / 7.0, parts, low, high);
  EXPECT_NEAR(parts[0], 6.0, 1e-12);
  EXPECT_NEAR(parts[1], 6.0, 1e-12);
}

}  // namespace
}  // namespace thermotwin::nc
