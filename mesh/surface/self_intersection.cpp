// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles of a surface that cut or cover each other. Distances below `slack` count as contact of
// neighbours, not as a cut: single precision files carry rounding of that order.

#include "mesh/surface/self_intersection.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/thread_pool.h"
#include "mesh/body/triangle_tree.h"
#include "mesh/surface/check.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

/// Whether the segment p-q passes through the triangle from one side to the other.
bool pierces(const Vector3d& p, const Vector3d& q, const Corners& t, double slack) {
  const Vector3d u = t[1] - t[0], v = t[2] - t[0], normal = u.cross(v);
  const double area = normal.norm();
  const double above_p = normal.dot(p - t[0]) / area, above_q = normal.dot(q - t[0]) / area;
  if (!((above_p > slack && above_q < -slack) || (above_p < -slack && above_q > slack))) return false;
  const Vector3d w = p + above_p / (above_p - above_q) * (q - p) - t[0];
  const double beta = w.cross(v).dot(normal) / (area * area), gamma = u.cross(w).dot(normal) / (area * area);
  const double rim = 1e-9;  // through an edge is through the surface
  return beta >= -rim && gamma >= -rim && beta + gamma <= 1.0 + rim;
}

/// Whether two triangles of one plane share some area: no edge separates them.
bool covers(const Corners& s, const Corners& t, double slack) {
  const Vector3d normal = (s[1] - s[0]).cross(s[2] - s[0]).normalized();
  for (const Vector3d& corner : t)
    if (std::abs(normal.dot(corner - s[0])) > slack) return false;
  for (const Corners* owner : {&s, &t}) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d across = normal.cross((*owner)[(i + 1) % 3] - (*owner)[i]).normalized();
      double s_low = 1e300, s_high = -1e300, t_low = 1e300, t_high = -1e300;
      for (const Vector3d& corner : s) {
        s_low = std::min(s_low, across.dot(corner));
        s_high = std::max(s_high, across.dot(corner));
      }
      for (const Vector3d& corner : t) {
        t_low = std::min(t_low, across.dot(corner));
        t_high = std::max(t_high, across.dot(corner));
      }
      if (s_high <= t_low + slack || t_high <= s_low + slack) return false;
    }
  }
  return true;
}

class Finder {
public:
  explicit Finder(const Surface& surface) : surface_(surface) {
    slack_ = 1e-6 * (surface.points.rowwise().maxCoeff() - surface.points.rowwise().minCoeff()).maxCoeff();
  }

  bool meet(int a, int b) const {
    const Corners s = corners(a), t = corners(b);
    // Corners that both have: i of a is shared[i] of b.
    std::array<int, 3> shared{-1, -1, -1};
    int common = 0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        if (surface_.triangles(i, a) == surface_.triangles(j, b)) shared[i] = j, ++common;
    }
    if (common >= 2) return covers(s, t, slack_);  // neighbours at an edge: only a fold is wrong
    if (common == 1) {
      const std::size_t i = std::find_if(shared.begin(), shared.end(), [](int j) { return j >= 0; }) - shared.begin();
      const std::size_t j = shared[i];
      return pierces(s[(i + 1) % 3], s[(i + 2) % 3], t, slack_) || pierces(t[(j + 1) % 3], t[(j + 2) % 3], s, slack_) ||
             covers(s, t, slack_);
    }
    for (std::size_t i = 0; i < 3; ++i)
      if (pierces(s[i], s[(i + 1) % 3], t, slack_) || pierces(t[i], t[(i + 1) % 3], s, slack_)) return true;
    return covers(s, t, slack_);
  }

  Corners corners(int triangle) const {
    return {surface_.points.col(surface_.triangles(0, triangle)), surface_.points.col(surface_.triangles(1, triangle)),
            surface_.points.col(surface_.triangles(2, triangle))};
  }

private:
  const Surface& surface_;
  double slack_ = 0.0;
};

}  // namespace

std::vector<std::pair<int, int>> cutting_triangles(const Surface& surface) {
  if (surface.triangles.cols() == 0) return {};
  const TriangleTree tree(surface.points, surface.triangles);
  const Finder finder(surface);
  const std::size_t count = surface.triangles.cols();
  std::vector<std::vector<int>> partners(count);
  core::parallel_for(
      0, count,
      [&](std::size_t i) {
        const int a = i;
        std::vector<int> near;
        tree.find(tree.box(a), near);
        for (const int b : near)
          if (b > a && finder.meet(a, b)) partners[i].push_back(b);
        std::sort(partners[i].begin(), partners[i].end());
      },
      256);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < count; ++i)
    for (const int b : partners[i]) pairs.emplace_back(i, b);
  return pairs;
}

void check_self_intersection(const Surface& surface, const std::string& body) {
  const auto pairs = cutting_triangles(surface);
  if (pairs.empty()) return;
  const auto [a, b] = pairs.front();
  long total = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (i == 0 || pairs[i].first != pairs[i - 1].first) ++total;
  int count = 0;
  const std::vector<int> shell = shells(surface, count);
  const auto between = std::count_if(pairs.begin(), pairs.end(),
                                     [&](const auto& pair) { return shell[pair.first] != shell[pair.second]; });
  const Corners at = Finder(surface).corners(a);
  const Vector3d centre = 1e3 / 3.0 * (at[0] + at[1] + at[2]);
  throw core::MeshError(
      "body '" + body + "'",
      fmt::format("triangle {} at ({:.4g}, {:.4g}, {:.4g}) mm and triangle {} cut each other "
                  "({} triangles in all do so{})",
                  a, centre.x(), centre.y(), centre.z(), b, total,
                  between > 0 ? fmt::format("; {} pairs are of two shells, whose solids overlap", between) : ""),
      between > 0 ? "solids that do not overlap (unite them before)" : "a surface without self-intersection");
}

}  // namespace thermotwin::mesh
