// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/stitching.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "mesh/surface/triangle_list.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

/// Corners of open edges, along x, to be asked for those in a range of it.
class Along {
public:
  Along(const Surface& s, std::vector<int> corners) : surface_(s), corners_(std::move(corners)) {
    std::sort(corners_.begin(), corners_.end(), [&](int a, int b) { return std::pair(x(a), a) < std::pair(x(b), b); });
  }
  template <class Visit>
  void between(double low, double high, const Visit& visit) const {
    for (auto at =
             std::lower_bound(corners_.begin(), corners_.end(), low, [&](int c, double value) { return x(c) < value; });
         at != corners_.end() && x(*at) <= high; ++at)
      visit(*at);
  }

private:
  double x(int corner) const { return surface_.points(0, corner); }
  const Surface& surface_;
  std::vector<int> corners_;
};

int join_corners(const Surface& s, Triangles& triangles, double tolerance) {
  std::vector<int> corners;
  if (open_edges(triangles, corners).empty()) return 0;
  const Along along(s, corners);
  std::map<int, int> becomes;
  for (const int corner : corners) {
    const Vector3d p = s.points.col(corner);
    along.between(p.x() - tolerance, p.x() + tolerance, [&](int other) {
      // The smaller number stays, and what has gone takes nobody along.
      if (other <= corner || becomes.contains(other) || becomes.contains(corner)) return;
      if ((s.points.col(other) - p).norm() <= tolerance) becomes[other] = corner;
    });
  }
  rename_corners(triangles, becomes);
  return std::ssize(becomes);
}

/// One pass; a triangle is split at one edge a pass.
int split_edges(const Surface& s, Triangles& triangles, double tolerance) {
  std::vector<int> corners;
  const std::vector<OpenEdge> open = open_edges(triangles, corners);
  const Along along(s, corners);
  std::set<std::size_t> touched;
  int split = 0;
  for (const OpenEdge& edge : open) {
    if (touched.contains(edge.triangle)) continue;
    const auto [t, part] = triangles[edge.triangle];
    int third = t[0];
    for (const int corner : t)
      if (corner != edge.from && corner != edge.to) third = corner;
    const Vector3d a = s.points.col(edge.from), b = s.points.col(edge.to), direction = b - a;
    const double length = direction.norm();
    std::vector<std::pair<double, int>> on;
    along.between(std::min(a.x(), b.x()) - tolerance, std::max(a.x(), b.x()) + tolerance, [&](int corner) {
      if (corner == edge.from || corner == edge.to || corner == third) return;
      const Vector3d p = s.points.col(corner);
      const double at = (p - a).dot(direction) / length;
      if (at > tolerance && at < length - tolerance && (a + at / length * direction - p).norm() <= tolerance)
        on.emplace_back(at, corner);
    });
    if (on.empty()) continue;
    std::sort(on.begin(), on.end());
    on.emplace_back(length, edge.to);
    int before = edge.from;
    for (std::size_t i = 0; i < on.size(); ++i) {
      const Vector3i piece(before, on[i].second, third);
      if (i == 0)
        triangles[edge.triangle].first = piece;
      else
        triangles.emplace_back(piece, part);
      before = on[i].second;
    }
    touched.insert(edge.triangle);
    ++split;
  }
  return split;
}

}  // namespace

int close_cracks(Surface& surface) {
  const double extent = (surface.points.rowwise().maxCoeff() - surface.points.rowwise().minCoeff()).maxCoeff();
  Triangles triangles = triangles_of(surface);
  std::vector<int> corners;
  int done = 0;
  for (const double share : {1e-6, 1e-5, 1e-4}) {
    if (open_edges(triangles, corners).empty()) break;
    done += join_corners(surface, triangles, share * extent);
    for (int pass = 0; pass < 10; ++pass) {
      const int split = split_edges(surface, triangles, share * extent);
      done += split;
      if (split == 0) break;
    }
  }
  if (done > 0) set_triangles(surface, triangles);
  return done;
}

}  // namespace thermotwin::mesh
