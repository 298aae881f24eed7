// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/self_intersection_repair.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "mesh/surface/check.h"
#include "mesh/surface/healing.h"
#include "mesh/surface/self_intersection.h"
#include "mesh/surface/triangle_list.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using Edge = std::pair<int, int>;

constexpr std::size_t longest_gap = 40;  // edges around triangles that were dropped

double area(const Vector3d& a, const Vector3d& b, const Vector3d& c) { return 0.5 * (b - a).cross(c - a).norm(); }

double area_of(const Surface& s, const Triangles& triangles) {
  double sum = 0.0;
  for (const auto& [t, part] : triangles) sum += area(s.points.col(t[0]), s.points.col(t[1]), s.points.col(t[2]));
  return sum;
}

/// Flat lid of a loop of edges: the triangulation of least area that makes no edge a second time; empty if there is
/// none.
std::vector<Vector3i> lid_of(const Surface& s, const std::vector<int>& loop, const std::set<Edge>& edges) {
  const std::size_t n = loop.size();
  constexpr double never = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> cost(n, std::vector<double>(n, 0.0));
  std::vector<std::vector<std::size_t>> by(n, std::vector<std::size_t>(n, 0));
  const auto at = [&](std::size_t i) -> Vector3d { return s.points.col(loop[i]); };
  for (std::size_t span = 2; span < n; ++span) {
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t j = i + span;
      cost[i][j] = never;
      if (span + 1 < n && edges.contains(std::minmax(loop[i], loop[j]))) continue;
      for (std::size_t k = i + 1; k < j; ++k) {
        const double of_it = area(at(i), at(k), at(j));
        const double longest = std::max({(at(i) - at(k)).norm(), (at(k) - at(j)).norm(), (at(j) - at(i)).norm()});
        if (2.0 * of_it <= 1e-6 * longest * longest) continue;
        if (const double sum = cost[i][k] + cost[k][j] + of_it; sum < cost[i][j]) cost[i][j] = sum, by[i][j] = k;
      }
    }
  }
  std::vector<Vector3i> lid;
  if (n < 3 || cost[0][n - 1] == never) return lid;
  std::vector<std::pair<std::size_t, std::size_t>> left{{0, n - 1}};
  while (!left.empty()) {
    const auto [i, j] = left.back();
    left.pop_back();
    if (j < i + 2) continue;
    const std::size_t k = by[i][j];
    lid.emplace_back(loop[i], loop[j], loop[k]);  // against the direction of the loop
    left.insert(left.end(), {{i, k}, {k, j}});
  }
  return lid;
}

/// Loops around the gaps that dropped triangles leave. Where two gaps meet in a corner, each has its own loop.
std::vector<std::vector<int>> gaps_of(const Triangles& triangles) {
  std::map<Edge, int> third;  // corner beyond each directed edge
  for (const auto& [t, part] : triangles)
    for (int i = 0; i < 3; ++i) third[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
  std::map<int, std::vector<int>> leaving;
  for (const auto& [edge, corner] : third)
    if (!third.contains({edge.second, edge.first})) leaving[edge.first].push_back(edge.second);
  // The open edge that leaves the end of the edge bounds the same fan of triangles there.
  const auto end_of_fan = [&](const Edge& edge) {
    int far = third.at(edge);
    for (std::size_t turns = 0; turns < triangles.size(); ++turns) {
      const auto beyond = third.find({far, edge.second});  // the triangle on the other side of the spoke
      if (beyond == third.end()) return far;
      far = beyond->second;
    }
    return -1;
  };
  std::set<Edge> left;
  for (const auto& [from, ends] : leaving)
    for (const int to : ends) left.insert({from, to});
  std::vector<std::vector<int>> gaps;
  while (!left.empty()) {
    Edge edge = *left.begin();
    std::vector<int> loop;
    while (left.erase(edge) > 0) {
      loop.push_back(edge.first);
      const auto& ends = leaving[edge.second];
      if (ends.empty() || ends.size() > 2) break;
      int to = ends[0];
      if (ends.size() == 2 && to == end_of_fan(edge)) to = ends[1];
      edge = {edge.second, to};
    }
    std::vector<int> sorted = loop;
    std::sort(sorted.begin(), sorted.end());
    if (edge.first == loop.front() && std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end())
      gaps.push_back(loop);
  }
  return gaps;
}

/// Without the triangles that are marked, and without what is then a small sheet of its own.
Triangles kept(const Surface& s, const Triangles& triangles, const std::vector<char>& drop) {
  Surface rest;
  rest.points = s.points;
  Triangles all;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!drop[t]) all.push_back(triangles[t]);
  set_triangles(rest, all);
  int count = 0;
  const std::vector<int> sheet = shells(rest, count);
  std::vector<char> open(count, 0);
  std::vector<double> size(count, 0.0);
  std::vector<int> corners;
  for (const OpenEdge& edge : open_edges(all, corners)) open[sheet[edge.triangle]] = 1;
  for (std::size_t t = 0; t < all.size(); ++t)
    size[sheet[t]] += area(s.points.col(all[t].first[0]), s.points.col(all[t].first[1]), s.points.col(all[t].first[2]));
  const double whole = std::accumulate(size.begin(), size.end(), 0.0);
  Triangles result;
  for (std::size_t t = 0; t < all.size(); ++t) {
    const std::size_t own = sheet[t];
    if (!open[own] || size[own] > largest_hole * whole) result.push_back(all[t]);
  }
  return result;
}

/// Drops the marked triangles and closes the gaps. Where not all of them can be closed, more is marked.
/// @return whether all are closed
bool replace(Surface& s, const Triangles& triangles, std::vector<char>& drop, double most) {
  Triangles rest = kept(s, triangles, drop);
  std::set<Edge> edges;
  std::map<Edge, int> part_of;
  for (const auto& [t, part] : rest) {
    for (int i = 0; i < 3; ++i) {
      edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
      part_of[{t[i], t[(i + 1) % 3]}] = part;
    }
  }
  Triangles added;
  for (const std::vector<int>& loop : gaps_of(rest)) {
    if (loop.size() > longest_gap) continue;
    for (const Vector3i& t : lid_of(s, loop, edges)) {
      added.emplace_back(t, part_of[{loop[0], loop[1]}]);
      for (int i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    }
  }
  const double of_lids = area_of(s, added);
  rest.insert(rest.end(), added.begin(), added.end());
  std::vector<int> corners;
  if (of_lids <= most && open_edges(rest, corners).empty()) {
    set_triangles(s, rest);
    return true;
  }
  const std::set<int> rim(corners.begin(), corners.end());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const int corner : triangles[t].first)
      if (rim.contains(corner)) drop[t] = 1;
  }
  return false;
}

/// Joins the ends of the shortest edge of triangles that cut others, where it is below 1e-4 of the extent and the
/// surface stays one. @return edges joined
int collapse_at(Surface& s, const std::vector<std::pair<int, int>>& pairs) {
  const double shortest = 1e-4 * (s.points.rowwise().maxCoeff() - s.points.rowwise().minCoeff()).maxCoeff();
  Triangles triangles = triangles_of(s);
  std::map<int, std::set<int>> around;
  for (const auto& [t, part] : triangles)
    for (int i = 0; i < 3; ++i) around[t[i]].insert({t[(i + 1) % 3], t[(i + 2) % 3]});
  std::set<int> cutting, touched;
  for (const auto& [a, b] : pairs) cutting.insert({a, b});
  std::map<int, int> becomes;
  for (const int number : cutting) {
    const Vector3i& t = triangles[number].first;
    Edge edge{-1, -1};
    double length = shortest;
    for (int i = 0; i < 3; ++i) {
      if (const double found = (s.points.col(t[i]) - s.points.col(t[(i + 1) % 3])).norm(); found < length) {
        length = found;
        edge = std::minmax(t[i], t[(i + 1) % 3]);
      }
    }
    if (edge.first < 0) continue;
    const std::set<int>&near = around[edge.first], &far = around[edge.second];
    std::vector<int> common;
    std::set_intersection(near.begin(), near.end(), far.begin(), far.end(), std::back_inserter(common));
    std::set<int> region(near);
    region.insert(far.begin(), far.end());
    if (common.size() != 2 ||
        std::any_of(region.begin(), region.end(), [&](int corner) { return touched.contains(corner); }))
      continue;
    touched.insert(region.begin(), region.end());
    becomes[edge.second] = edge.first;
  }
  rename_corners(triangles, becomes);
  set_triangles(s, triangles);
  return std::ssize(becomes);
}

}  // namespace

int mend_cuts(Surface& surface) {
  constexpr std::size_t most_pairs = 1000;
  constexpr int rounds = 5, widenings = 3;
  constexpr double volume_change = 0.01;
  Surface now = surface;
  const double most = largest_hole * area_of(surface, triangles_of(surface)), before = enclosed_volume(surface);
  int dropped = 0;
  for (int pass = 0; pass < rounds; ++pass) {
    const auto pairs = cutting_triangles(now);
    if (pairs.empty() || pairs.size() > most_pairs) break;
    Surface joined = now;
    const int count = collapse_at(joined, pairs);
    if (count == 0 || cutting_triangles(joined).size() >= pairs.size()) break;
    now = joined;
    dropped += 2 * count;
  }
  for (int round = 0; round <= rounds; ++round) {
    const auto pairs = cutting_triangles(now);
    if (pairs.empty()) {
      if (dropped == 0 || !(std::abs(enclosed_volume(now) - before) <= volume_change * std::abs(before))) return 0;
      surface = now;
      return dropped;
    }
    int count = 0;
    const std::vector<int> shell = shells(now, count);
    const bool overlap =
        std::any_of(pairs.begin(), pairs.end(), [&](const auto& p) { return shell[p.first] != shell[p.second]; });
    if (overlap || pairs.size() > most_pairs || round == rounds) return 0;
    const Triangles triangles = triangles_of(now);
    std::vector<char> drop(triangles.size(), 0);
    std::vector<int> cuts(triangles.size(), 0);
    for (const auto& [a, b] : pairs) ++cuts[a], ++cuts[b];
    for (const auto& [i, j] : pairs) {
      // First the one of each pair that has more cuts; later both.
      if (round > 0 || cuts[i] >= cuts[j]) drop[i] = 1;
      if (round > 0 || cuts[j] > cuts[i]) drop[j] = 1;
    }
    for (int ring = 0; ring < round; ++ring) {
      std::set<int> near;
      for (std::size_t t = 0; t < triangles.size(); ++t)
        if (drop[t]) near.insert(triangles[t].first.begin(), triangles[t].first.end());
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (const int corner : triangles[t].first)
          if (near.contains(corner)) drop[t] = 1;
      }
    }
    bool closed = false;
    for (int attempt = 0; attempt < widenings && !closed; ++attempt) closed = replace(now, triangles, drop, most);
    if (!closed) return 0;
    dropped += std::count(drop.begin(), drop.end(), 1);
  }
  return 0;
}

}  // namespace thermotwin::mesh
