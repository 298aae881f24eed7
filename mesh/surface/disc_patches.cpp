// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/disc_patches.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <unordered_set>

#include "core/units.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;
using Neighbours = std::vector<std::array<int, 3>>;  // triangle beyond edge i, i + 1

const double sharp = std::cos(40.0 * core::units::deg), bend = std::cos(50.0 * core::units::deg);

Neighbours neighbours_of(const Surface& s) {
  std::map<std::pair<int, int>, int> owner;  // of a directed edge
  for (int t = 0; t < s.triangles.cols(); ++t)
    for (int i = 0; i < 3; ++i) owner[{s.triangles(i, t), s.triangles((i + 1) % 3, t)}] = t;
  Neighbours result(s.triangles.cols(), {-1, -1, -1});
  for (const auto& [edge, t] : owner) {
    for (int i = 0; i < 3; ++i) {
      if (s.triangles(i, t) == edge.first) {
        if (const auto beyond = owner.find({edge.second, edge.first}); beyond != owner.end())
          result[t][i] = beyond->second;
      }
    }
  }
  return result;
}

}  // namespace

std::vector<int> disc_patches(const Surface& surface) {
  const std::size_t count = surface.triangles.cols();
  const Neighbours beyond = neighbours_of(surface);
  std::vector<Vector3d> normal(count), centre(count);
  for (std::size_t t = 0; t < count; ++t) {
    const Eigen::Vector3i c = surface.triangles.col(t);
    const Vector3d a = surface.points.col(c[0]), b = surface.points.col(c[1]), d = surface.points.col(c[2]);
    normal[t] = (b - a).cross(d - a).normalized();
    centre[t] = (a + b + d) / 3.0;
  }
  std::vector<int> patch(count, -1);
  int patches = 0;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (patch[seed] >= 0) continue;
    const int own = patches++;
    std::unordered_set<int> corners;
    // Nearest to the seed first: compact patches.
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>> next;
    next.emplace(0.0, seed);
    while (!next.empty()) {
      const std::size_t t = next.top().second;
      next.pop();
      if (patch[t] >= 0) continue;
      const Eigen::Vector3i corner = surface.triangles.col(t);
      int shared = 0, opposite = -1;
      for (int i = 0; i < 3; ++i)
        if (beyond[t][i] >= 0 && patch[beyond[t][i]] == own) ++shared, opposite = corner[(i + 2) % 3];
      // A single edge in common, and the corner opposite already there: the patch would become a ring.
      if (shared == 1 && corners.contains(opposite)) continue;
      patch[t] = own;
      for (const int c : corner) corners.insert(c);
      for (const int other : beyond[t]) {
        if (other < 0) continue;
        const std::size_t o = other;
        if (patch[o] < 0 && normal[o].dot(normal[t]) > sharp && normal[o].dot(normal[seed]) > bend)
          next.emplace((centre[o] - centre[seed]).norm(), other);
      }
    }
  }
  return patch;
}

}  // namespace thermotwin::mesh
