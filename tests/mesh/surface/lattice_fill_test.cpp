// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies from a cut lattice: volumes, boundaries and shapes of elements.
#include "mesh/surface/lattice_fill.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mesh/body/tet_mesh.h"
#include "mesh/surface/check.h"
#include "mesh/surface/winding_number.h"
#include "tests/mesh/surfaces.h"

namespace thermotwin::mesh {
namespace {

using Eigen::Vector3d;

/// A ball of radius 1: an octahedron whose triangles are divided `times` times.
Surface ball(int times, const Vector3d& centre = Vector3d::Zero()) {
  Surface s;
  const int n = 1 << times;
  std::vector<Vector3d> points;
  std::vector<Eigen::Vector3i> triangles;
  for (int octant = 0; octant < 8; ++octant) {
    const Vector3d sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    const auto corner = [&](int i, int j) {
      points.push_back(centre + Vector3d(i, j, n - i - j).normalized().cwiseProduct(sign));
      return static_cast<int>(points.size()) - 1;
    };
    const auto add = [&](int a, int b, int c) {
      if (sign.prod() < 0) std::swap(b, c);
      triangles.emplace_back(a, b, c);
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j + 1 < n) add(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
    }
  }
  s.points.resize(3, std::ssize(points));
  for (std::size_t i = 0; i < points.size(); ++i) s.points.col(i) = points[i];
  s.triangles.resize(3, std::ssize(triangles));
  for (std::size_t i = 0; i < triangles.size(); ++i) s.triangles.col(i) = triangles[i];
  s.part.assign(triangles.size(), 0);
  s.part_names = {""};
  weld(s);
  return s;
}

TetMesh body_of(const LatticeFill& fill) {
  TetMesh mesh;
  mesh.points = fill.points;
  mesh.tets = fill.tets;
  build_boundary(mesh, "test");  // refuses flat and inverted elements, and faces of three
  return mesh;
}

/// Edges of the boundary that do not belong to an even number of its triangles.
int open_edges(const TetMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (Eigen::Index f = 0; f < mesh.face_count(); ++f)
    for (const auto& edge : face_edge) ++uses[std::minmax(mesh.faces(edge[0], f), mesh.faces(edge[1], f))];
  return std::count_if(uses.begin(), uses.end(), [](const auto& use) { return use.second % 2 != 0; });
}

TEST(LatticeFill, OfABallLiesOnItAndIsWellShaped) {
  const Surface surface = ball(5);
  const LatticeFill fill = fill_by_lattice(surface, 0.2);
  const TetMesh mesh = body_of(fill);
  const double exact = enclosed_volume(surface);
  EXPECT_NEAR(fill.inside, exact, 0.01 * exact);
  EXPECT_NEAR(mesh.total_volume(), exact, 0.02 * exact);
  EXPECT_NEAR(fill.volume, mesh.total_volume(), 1e-12);
  EXPECT_EQ(fill.ambiguous, 0.0);
  EXPECT_EQ(fill.crumbs, 0);
  EXPECT_EQ(open_edges(mesh), 0);
  for (const int node : mesh.faces.reshaped()) EXPECT_NEAR(mesh.points.col(node).norm(), 1.0, 0.004);
  EXPECT_GT(quality(mesh).minimum, 0.1);
  EXPECT_GT(quality(mesh).mean, 0.7);
}

TEST(LatticeFill, ErrorOfTheVolumeFallsWithTheSquareOfTheSpacing) {
  const Surface surface = ball(6);
  const double exact = enclosed_volume(surface);
  const double coarse = exact - fill_by_lattice(surface, 0.3).volume,
               fine = exact - fill_by_lattice(surface, 0.15).volume;
  EXPECT_GT(coarse / fine, 3.0);
  EXPECT_LT(coarse / fine, 5.5);
}

TEST(LatticeFill, ShellsThatOverlapAreOneBody) {
  const Surface two =
      samples::together(samples::box_surface({0, 0, 0}, {2, 2, 2}), samples::box_surface({1, 1, 1}, {3, 3, 3}));
  const LatticeFill fill = fill_by_lattice(two, 0.2);
  EXPECT_NEAR(fill.inside, 15.0, 0.2);
  EXPECT_NEAR(fill.volume, 15.0, 0.3);
  const TetMesh mesh = body_of(fill);
  EXPECT_EQ(open_edges(mesh), 0);
  EXPECT_GT(quality(mesh).minimum, 0.02);
}

TEST(LatticeFill, ACavityStaysAndAHoleIsClosed) {
  Surface hollow = samples::box_surface({1, 1, 1}, {2, 2, 2});
  samples::turn_over(hollow);
  const Surface shell = samples::together(samples::box_surface({0, 0, 0}, {3, 3, 3}), hollow);
  EXPECT_NEAR(fill_by_lattice(shell, 0.2).volume, 26.0, 0.4);
  Surface leaking = ball(4);
  leaking.triangles.conservativeResize(3, leaking.triangles.cols() - 3);
  leaking.part.resize(leaking.triangles.cols());
  const LatticeFill closed = fill_by_lattice(leaking, 0.2);
  EXPECT_NEAR(closed.volume, 4.0 / 3.0 * std::numbers::pi, 0.1);
  EXPECT_LT(closed.ambiguous, 0.01 * closed.inside);
}

TEST(LatticeFill, AnOpenSurfaceIsAmbiguous) {
  Surface half = ball(4);
  std::vector<char> take(half.triangles.cols());
  for (std::size_t t = 0; t < take.size(); ++t) take[t] = half.points(2, half.triangles(0, t)) >= 0.0;
  const LatticeFill fill = fill_by_lattice(select(half, take), 0.2);
  EXPECT_GT(fill.ambiguous, 0.1 * fill.inside);
}

TEST(WindingNumber, AgreesWithTheSumOverAllTriangles) {
  const Surface surface = samples::together(ball(4), ball(4, {1.2, 0.3, 0.1}));
  const WindingNumber fast(surface);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-2.0, 3.0);
  double worst = 0.0;
  for (int n = 0; n < 500; ++n) {
    const Vector3d point(place(random), place(random), place(random));
    worst = std::max(worst, std::abs(fast(point) - winding(surface, point)));
  }
  EXPECT_LT(worst, 0.02);
}

}  // namespace
}  // namespace thermotwin::mesh
