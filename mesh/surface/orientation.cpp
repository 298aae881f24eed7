// SPDX-License-Identifier: GPL-3.0-or-later
// Which way the triangles of a surface turn.

#include "mesh/surface/orientation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>

#include "mesh/surface/check.h"
#include "mesh/surface/healing.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

namespace {

double area(const Surface& s, Eigen::Index t) {
  const Eigen::Vector3d a = s.points.col(s.triangles(0, t)), b = s.points.col(s.triangles(1, t)),
                        c = s.points.col(s.triangles(2, t));
  return 0.5 * (b - a).cross(c - a).norm();
}

void turn(Surface& s, int t) { std::swap(s.triangles(1, t), s.triangles(2, t)); }

struct Use {
  int triangle;
  bool forward;  ///< from the smaller node to the larger one
};

}  // namespace

int make_consistent(Surface& surface) {
  const int count = surface.triangles.cols();
  std::map<std::pair<int, int>, std::vector<Use>> edges;
  for (int t = 0; t < count; ++t) {
    for (int i = 0; i < 3; ++i) {
      const int a = surface.triangles(i, t), b = surface.triangles((i + 1) % 3, t);
      edges[std::minmax(a, b)].push_back({t, a < b});
    }
  }
  // Triangle beyond each edge that exactly two have, and whether it turns the other way.
  std::vector<std::vector<std::pair<int, bool>>> beyond(count);
  for (const auto& [edge, uses] : edges) {
    if (uses.size() != 2) continue;
    const bool differ = uses[0].forward == uses[1].forward;
    beyond[uses[0].triangle].emplace_back(uses[1].triangle, differ);
    beyond[uses[1].triangle].emplace_back(uses[0].triangle, differ);
  }
  std::vector<int> side(count, -1);
  int turned = 0;
  for (int seed = 0; seed < count; ++seed) {
    if (side[seed] >= 0) continue;
    std::vector<int> sheet{seed};
    side[seed] = 0;
    bool orientable = true;
    double share[2] = {0.0, 0.0};
    for (std::size_t k = 0; k < sheet.size(); ++k) {
      const std::size_t t = sheet[k];
      share[side[t]] += area(surface, sheet[k]);
      for (const auto& [other, differ] : beyond[t]) {
        const int wanted = differ ? 1 - side[t] : side[t];
        int& found = side[other];
        if (found < 0) {
          found = wanted;
          sheet.push_back(other);
        } else if (found != wanted) {
          orientable = false;
        }
      }
    }
    if (!orientable) continue;
    const int wrong = share[1] <= share[0] ? 1 : 0;
    for (const int t : sheet)
      if (side[t] == wrong) turn(surface, t), ++turned;
  }
  return turned;
}

int turn_outward(Surface& surface) {
  int count = 0;
  const std::vector<int> shell = shells(surface, count);
  const std::size_t n = count;
  std::vector<double> volume(n, 0.0);
  const Eigen::Vector3d middle = surface.points.rowwise().mean();
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3d a = surface.points.col(surface.triangles(0, t)) - middle,
                          b = surface.points.col(surface.triangles(1, t)) - middle,
                          c = surface.points.col(surface.triangles(2, t)) - middle;
    volume[shell[t]] += a.dot(b.cross(c)) / 6.0;
  }
  if (std::all_of(volume.begin(), volume.end(), [](double v) { return v >= 0.0; })) return 0;
  if (!holes_of(triangles_of(surface)).empty()) return 0;
  std::vector<Surface> alone;
  for (int s = 0; s < count; ++s) {
    std::vector<char> take(shell.size());
    std::transform(shell.begin(), shell.end(), take.begin(), [&](int number) { return number == s; });
    alone.push_back(select(surface, take));
  }
  const auto within = [&](std::size_t inner, std::size_t outer) {
    return inner != outer && std::abs(winding(alone[outer], alone[inner].points.col(0))) > 0.5;
  };
  const auto depth = [&](std::size_t inner) {
    int shells_around = 0;
    for (std::size_t outer = 0; outer < n; ++outer) shells_around += within(inner, outer);
    return shells_around;
  };
  std::vector<char> over(n, 0);
  int turned = 0;
  for (std::size_t s = 0; s < n; ++s) {
    if (volume[s] >= 0.0 || depth(s) > 0) continue;
    // In it, what turns as its depth asks is right already.
    for (std::size_t inner = 0; inner < n; ++inner)
      if (inner == s || (within(inner, s) && (volume[inner] > 0.0) != (depth(inner) % 2 == 0))) over[inner] = 1;
  }
  for (std::size_t s = 0; s < n; ++s) turned += over[s];
  for (std::size_t t = 0; t < shell.size(); ++t)
    if (over[shell[t]]) turn(surface, t);
  return turned;
}

}  // namespace thermotwin::mesh
