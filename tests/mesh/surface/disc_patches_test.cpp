// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/disc_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "mesh/import/gmsh_mesher.h"
#include "mesh/surface/check.h"
#include "mesh/surface/surface.h"
#include "tests/mesh/surfaces.h"

using namespace thermotwin;

namespace {

mesh::Surface torus(int turns, int sides) {
  mesh::Surface s;
  s.points.resize(3, turns * sides);
  s.triangles.resize(3, 2 * turns * sides);
  const auto corner = [&](int i, int j) { return (i % turns) * sides + j % sides; };
  for (int i = 0; i < turns; ++i) {
    for (int j = 0; j < sides; ++j) {
      const double u = 2.0 * std::numbers::pi * i / turns, v = 2.0 * std::numbers::pi * j / sides,
                   r = 0.1 + 0.04 * std::cos(v);
      s.points.col(corner(i, j)) << r * std::cos(u), r * std::sin(u), 0.04 * std::sin(v);
      s.triangles.col(2 * corner(i, j)) << corner(i, j), corner(i + 1, j), corner(i + 1, j + 1);
      s.triangles.col(2 * corner(i, j) + 1) << corner(i, j), corner(i + 1, j + 1), corner(i, j + 1);
    }
  }
  s.part.assign(s.triangles.cols(), 0);
  s.part_names = {""};
  return s;
}

TEST(DiscPatches, EachIsADiscWhoseRimPassesNoCornerTwice) {
  const mesh::Surface s = torus(40, 20);
  const std::vector<int> patch = mesh::disc_patches(s);
  std::map<int, std::vector<Eigen::Index>> triangles;
  for (std::size_t t = 0; t < patch.size(); ++t) triangles[patch[t]].push_back(t);
  EXPECT_GT(triangles.size(), 5u);
  EXPECT_LT(triangles.size(), 200u);
  for (const auto& [number, own] : triangles) {
    std::set<int> corners;
    std::set<std::pair<int, int>> edges, directed;
    for (const Eigen::Index t : own) {
      for (int i = 0; i < 3; ++i) {
        const int a = s.triangles(i, t), b = s.triangles((i + 1) % 3, t);
        corners.insert(a);
        edges.insert(std::minmax(a, b));
        directed.insert({a, b});
      }
    }
    EXPECT_EQ(std::ssize(corners) - std::ssize(edges) + std::ssize(own), 1) << number;
    std::map<int, int> leaving;
    for (const auto& [a, b] : directed) {
      if (!directed.contains({b, a})) {
        EXPECT_EQ(++leaving[a], 1);
      }
    }
  }
}

TEST(DiscPatches, LaterAttemptsFillTheSameVolume) {
  mesh::ImportOptions options;
  options.body = "ring";
  options.element_size_m = 0.02;
  const mesh::Surface s = torus(40, 20);
  ASSERT_EQ(mesh::attempts_on_surfaces().size(), 3u);
  for (const mesh::Attempt& attempt : mesh::attempts_on_surfaces()) {
    const mesh::TetMesh mesh = mesh::mesh_closed_surface(s, options, attempt);
    EXPECT_NEAR(mesh.total_volume(), mesh::enclosed_volume(s), 0.05 * mesh::enclosed_volume(s));
    EXPECT_GT(mesh::quality(mesh).minimum, 0.02);
    if (attempt.patches == mesh::Attempt::Patches::as_in_file) {
      EXPECT_NEAR(mesh.total_volume(), mesh::enclosed_volume(s), 1e-9 * mesh::enclosed_volume(s));
    }
  }
}

}  // namespace
