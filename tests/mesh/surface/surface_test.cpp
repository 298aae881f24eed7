// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/surface.h"

#include <gtest/gtest.h>

#include "mesh/body/triangle_tree.h"
#include "mesh/import/import.h"
#include "mesh/surface/check.h"
#include "tests/mesh/samples.h"
#include "tests/mesh/surfaces.h"

using namespace thermotwin;
using Eigen::Vector3d;
using samples::box_surface;
using samples::message_of;

namespace {

const Vector3d origin = Vector3d::Zero();

std::string fault(const mesh::Surface& surface) {
  return message_of([&] { mesh::check_surface(surface, "cover", "cover.stl"); });
}

void expect_words(const std::string& message, const std::vector<const char*>& words) {
  for (const char* word : words)
    EXPECT_NE(message.find(word), std::string::npos) << "'" << message << "' lacks: " << word;
}

mesh::Surface without(const mesh::Surface& surface, int triangle) {
  mesh::Surface result = surface;
  const Eigen::Index last = result.triangles.cols() - 1;
  result.triangles.col(triangle) = result.triangles.col(last).eval();
  result.triangles.conservativeResize(3, last);
  result.part.resize(last);
  return result;
}

TEST(Surface, AGoodBoxPasses) { EXPECT_EQ(fault(box_surface(origin, {0.1, 0.2, 0.3})), ""); }

TEST(Surface, Hole) {
  expect_words(fault(without(box_surface(origin, {0.1, 0.1, 0.1}), 11)), {"cover", "holes", "3 open edges", "mm"});
}

TEST(Surface, FlippedFace) {
  mesh::Surface s = box_surface(origin, {0.1, 0.1, 0.1});
  std::swap(s.triangles(0, 4), s.triangles(1, 4));
  expect_words(fault(s), {"flipped", "at 3 edges"});
}

TEST(Surface, InsideOut) {
  mesh::Surface s = box_surface(origin, {0.1, 0.1, 0.1});
  samples::turn_over(s);
  expect_words(fault(s), {"inside out"});
}

TEST(Surface, Duplicate) {
  mesh::Surface s = box_surface(origin, {0.1, 0.1, 0.1});
  s.triangles.conservativeResize(3, 13);
  s.triangles.col(12) << s.triangles(1, 3), s.triangles(2, 3), s.triangles(0, 3);
  s.part.push_back(0);
  expect_words(fault(s), {"triangle 12", "duplicate of triangle 3"});
}

TEST(Surface, Degenerate) {
  mesh::Surface s = box_surface(origin, {0.1, 0.1, 0.1});
  s.triangles(1, 2) = s.triangles(0, 2);
  expect_words(fault(s), {"triangle 2", "degenerate"});
}

TEST(Surface, NonManifold) {
  // Two boxes that share an edge only: four triangles at it.
  mesh::Surface s =
      samples::together(box_surface(origin, {0.1, 0.1, 0.1}), box_surface({0.1, 0.1, 0.0}, {0.2, 0.2, 0.1}));
  EXPECT_EQ(mesh::weld(s), 0);
  EXPECT_EQ(s.points.cols(), 14);
  expect_words(fault(s), {"more than two triangles"});
}

TEST(Surface, WrongUnit) {
  expect_words(fault(box_surface(origin, {100, 100, 100})), {"cover.stl", "unit", "100 m"});
  expect_words(fault(box_surface(origin, {1e-4, 1e-4, 1e-4})), {"unit"});
}

TEST(Surface, SelfIntersection) {
  const mesh::Surface a = box_surface(origin, {0.1, 0.1, 0.1});
  expect_words(fault(samples::together(a, box_surface({0.05, 0.05, 0.05}, {0.15, 0.15, 0.15}))), {"cut each other"});
  // A bar right through, and one whose sides lie in the planes of the box.
  expect_words(fault(samples::together(a, box_surface({0.03, 0.04, -0.1}, {0.06, 0.07, 0.2}))), {"cut each other"});
  expect_words(fault(samples::together(a, box_surface({0.1, 0.02, 0.02}, {0.2, 0.08, 0.08}))), {"cut each other"});
  // Apart by a hundredth of the size: fine.
  EXPECT_EQ(fault(samples::together(a, box_surface({0.101, 0, 0}, {0.2, 0.1, 0.1}))), "");
}

TEST(Surface, FoldedNeighboursCut) {
  // A tetrahedron pressed flat on itself: two faces at one edge cover each other.
  mesh::Surface s;
  s.points.resize(3, 5);
  s.points << 0, 0.1, 0, 0.05, 0.03, 0, 0, 0.1, 0.04, 0.03, 0, 0, 0, 0, 0.05;
  s.triangles.resize(3, 6);
  s.triangles << 0, 1, 0, 1, 2, 0,  //
      2, 2, 1, 4, 4, 4,             //
      1, 4, 4, 2, 0, 1;
  s.part.assign(6, 0);
  s.part_names = {""};
  const std::string message = fault(s);
  EXPECT_FALSE(message.empty());
}

TEST(Surface, CavitiesAreSolidsInsideOut) {
  const mesh::Surface outer = box_surface(origin, {0.1, 0.1, 0.1});
  mesh::Surface inner = box_surface({0.03, 0.03, 0.03}, {0.07, 0.07, 0.07});
  expect_words(fault(samples::together(outer, inner)), {"inside out", "cavity"});
  samples::turn_over(inner);
  const mesh::Surface hollow = samples::together(outer, inner);
  EXPECT_EQ(fault(hollow), "");
  EXPECT_EQ(mesh::pieces(hollow, "cover").size(), 1u);
  // A solid in the cavity, and one beside: three pieces, the cavity with the outer box.
  const auto all = samples::together(samples::together(hollow, box_surface({0.04, 0.04, 0.04}, {0.06, 0.06, 0.06})),
                                     box_surface({0.2, 0, 0}, {0.3, 0.1, 0.1}));
  const auto parts = mesh::pieces(all, "cover");
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].triangles.cols(), 24);
}

TEST(Surface, WeldJoinsAcrossCells) {
  mesh::Surface s = box_surface(origin, {0.1, 0.1, 0.1});
  mesh::Surface loose;
  loose.points.resize(3, 36);
  loose.triangles.resize(3, 12);
  for (int t = 0; t < 12; ++t) {
    for (int i = 0; i < 3; ++i) {
      loose.points.col(3 * t + i) = s.points.col(s.triangles(i, t)) + 4e-8 * Vector3d(t % 2, i % 2, 0);
      loose.triangles(i, t) = 3 * t + i;
    }
  }
  loose.part = s.part;
  loose.part_names = s.part_names;
  mesh::weld(loose);
  EXPECT_EQ(loose.points.cols(), 8);
  EXPECT_EQ(fault(loose), "");
}

TEST(TriangleTree, NearestAgreesWithTryingAll) {
  const mesh::Surface s = samples::together(box_surface(origin, {1, 2, 3}), box_surface({5, 5, 5}, {6, 7, 6}));
  const mesh::TriangleTree tree(s.points, s.triangles);
  unsigned state = 1;
  const auto random = [&] { return (state = state * 1664525u + 1013904223u) / 4294967296.0 * 10.0 - 1.0; };
  for (int n = 0; n < 200; ++n) {
    const Vector3d p(random(), random(), random());
    double best = 1e300;
    for (Eigen::Index t = 0; t < s.triangles.cols(); ++t) {
      best =
          std::min(best, (mesh::nearest_on_triangle(p, s.points.col(s.triangles(0, t)), s.points.col(s.triangles(1, t)),
                                                    s.points.col(s.triangles(2, t))) -
                          p)
                             .norm());
    }
    const auto found = tree.nearest(p);
    EXPECT_DOUBLE_EQ(found.distance, best);
    EXPECT_NEAR((found.point - p).norm(), best, 1e-14);
  }
}

}  // namespace
