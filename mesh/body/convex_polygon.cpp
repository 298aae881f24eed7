// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body/convex_polygon.h"

#include <algorithm>
#include <utility>

namespace thermotwin::mesh {

namespace {

double value(const Eigen::Vector3d& line, const Eigen::Vector2d& at) {
  return line[0] + line[1] * at[0] + line[2] * at[1];
}

/// Lines through the sides, not negative inside. Corners that rounding has parted make a side without a
/// direction: its neighbours bound the polygon as well.
std::vector<Eigen::Vector3d> sides(const Polygon& polygon) {
  constexpr double no_side = 1e-7;  // of the polygon's extent
  double extent = 0.0;
  for (const Eigen::Vector2d& corner : polygon) extent = std::max(extent, (corner - polygon[0]).cwiseAbs().maxCoeff());
  std::vector<Eigen::Vector3d> lines;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d p = polygon[i], way = polygon[i + 1 < polygon.size() ? i + 1 : 0] - p;
    if (way.cwiseAbs().maxCoeff() > no_side * extent)
      lines.emplace_back(way[1] * p[0] - way[0] * p[1], -way[1], way[0]);
  }
  return lines;
}

}  // namespace

void cut(Polygon& polygon, const Eigen::Vector3d& line, Polygon& spare) {
  spare.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    const double at_a = value(line, a), at_b = value(line, b);
    if (at_a >= 0.0) spare.push_back(a);
    if ((at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0)) spare.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  std::swap(polygon, spare);
}

double area(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Eigen::Vector2d u = polygon[i - 1] - polygon[0], v = polygon[i] - polygon[0];
    twice += u[0] * v[1] - u[1] * v[0];
  }
  return 0.5 * twice;
}

Eigen::Vector2d middle(const Polygon& polygon) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : polygon) sum += corner;
  return sum / std::ssize(polygon);
}

Polygon common_part(const Polygon& a, const Polygon& b) {
  Polygon rest = a, spare;
  for (const Eigen::Vector3d& line : sides(b)) cut(rest, line, spare);
  return rest;
}

std::vector<Polygon> less(const Polygon& a, const Polygon& b) {
  std::vector<Polygon> pieces;
  Polygon rest = a, spare;
  for (const Eigen::Vector3d& line : sides(b)) {
    Polygon beyond = rest;
    cut(beyond, -line, spare);
    if (beyond.size() > 2) pieces.push_back(std::move(beyond));
    cut(rest, line, spare);
  }
  return pieces;
}

}  // namespace thermotwin::mesh
