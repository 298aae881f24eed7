// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/healing.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "core/text.h"
#include "mesh/surface/orientation.h"
#include "mesh/surface/self_intersection_repair.h"
#include "mesh/surface/stitching.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double no_area = 1e-9;  // of the square of the longest edge, as check_surface has it

double area(const Surface& s, const Vector3i& t) {
  const Vector3d a = s.points.col(t[0]), b = s.points.col(t[1]), c = s.points.col(t[2]);
  return 0.5 * (b - a).cross(c - a).norm();
}

/// The triangle with its first corner the smallest: the same for the same corners and direction.
std::array<int, 3> turned(const Vector3i& t) {
  std::array<int, 3> key{t[0], t[1], t[2]};
  std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
  return key;
}

int drop_duplicates(Triangles& triangles) {
  std::set<std::array<int, 3>> seen;
  return std::erase_if(triangles, [&](const auto& t) { return !seen.insert(turned(t.first)).second; });
}

/// A fold without thickness, or the wall between two solids that touch: both triangles go.
int drop_opposites(Triangles& triangles) {
  std::set<std::array<int, 3>> all;
  for (const auto& [t, part] : triangles) all.insert(turned(t));
  const auto dropped = std::erase_if(triangles, [&](const auto& t) {
    return all.contains(turned({t.first[0], t.first[2], t.first[1]}));
  });
  return dropped / 2;
}

/// A triangle whose corner c lies on its longest edge from a to b: the neighbour at that edge, with the corner d,
/// becomes two triangles, and the sliver goes.
int split_at_slivers(const Surface& s, Triangles& triangles) {
  int healed = 0;
  for (std::size_t t = 0; t < triangles.size();) {
    const Vector3i corner = triangles[t].first;
    int opposite = 0;  // corner opposite to the longest edge
    double longest = 0.0;
    for (int i = 0; i < 3; ++i) {
      if (const double length = (s.points.col(corner[(i + 1) % 3]) - s.points.col(corner[(i + 2) % 3])).norm();
          length > longest)
        longest = length, opposite = i;
    }
    if (2.0 * area(s, corner) > no_area * longest * longest) {
      ++t;
      continue;
    }
    const int c = corner[opposite], a = corner[(opposite + 1) % 3], b = corner[(opposite + 2) % 3];
    const auto neighbour = std::find_if(triangles.begin(), triangles.end(), [&](const auto& other) {
      for (int i = 0; i < 3; ++i)
        if (other.first[i] == b && other.first[(i + 1) % 3] == a && other.first[(i + 2) % 3] != c) return true;
      return false;
    });
    if (neighbour == triangles.end()) {
      ++t;  // left for the check to name
      continue;
    }
    int d = 0;
    for (int i = 0; i < 3; ++i)
      if (neighbour->first[i] != a && neighbour->first[i] != b) d = neighbour->first[i];
    const int part = neighbour->second;
    neighbour->first = {b, c, d};
    triangles[t] = {Vector3i(c, a, d), part};
    ++healed;
    if (healed > 100000) break;
    t = 0;  // a new triangle may be a sliver again
  }
  return healed;
}

}  // namespace

std::string Healing::brief() const {
  std::vector<std::string> words;
  if (duplicates > 0) words.push_back(fmt::format("{} duplicate triangles dropped", duplicates));
  if (opposites > 0) words.push_back(fmt::format("{} pairs of opposite triangles in one place dropped", opposites));
  if (slivers > 0) words.push_back(fmt::format("{} triangles without area merged into a neighbour", slivers));
  if (cracks > 0) words.push_back(fmt::format("cracks closed at {} corners and edges", cracks));
  if (flipped > 0) words.push_back(fmt::format("{} flipped triangles turned over", flipped));
  if (holes > 0) words.push_back(fmt::format("{} small holes closed by {} triangles", holes, triangles));
  if (cuts > 0) words.push_back(fmt::format("{} triangles that cut each other, or are next to such, replaced", cuts));
  if (shells > 0) words.push_back(fmt::format("{} shells that were inside out turned over", shells));
  return core::join(words);
}

std::vector<std::vector<int>> holes_of(const Triangles& triangles) {
  std::set<std::pair<int, int>> edges;
  for (const auto& [t, part] : triangles)
    for (int i = 0; i < 3; ++i) edges.insert({t[i], t[(i + 1) % 3]});
  std::map<int, int> next;
  std::set<int> crowded;
  for (const auto& [from, to] : edges)
    if (!edges.contains({to, from}) && !next.emplace(from, to).second) crowded.insert(from);
  std::vector<std::vector<int>> holes;
  while (!next.empty()) {
    std::vector<int> loop;
    bool clean = true;
    for (int node = next.begin()->first;;) {
      const auto edge = next.find(node);
      if (edge == next.end()) break;
      loop.push_back(node);
      clean = clean && !crowded.contains(node);
      node = edge->second;
      next.erase(edge);
      if (node == loop.front()) {
        if (clean) holes.push_back(loop);
        break;
      }
    }
  }
  return holes;
}

namespace {

void close_holes(Surface& surface, Triangles& triangles, Healing& done) {
  double whole = 0.0;
  std::map<std::pair<int, int>, int> part_of;
  for (const auto& [t, part] : triangles) {
    whole += area(surface, t);
    for (int i = 0; i < 3; ++i) part_of[{t[i], t[(i + 1) % 3]}] = part;
  }
  double left = largest_hole * whole;
  for (const std::vector<int>& loop : holes_of(triangles)) {
    if (loop.size() < 3 || loop.size() > longest_hole) continue;
    Vector3d middle = Vector3d::Zero();
    for (const int node : loop) middle += surface.points.col(node) / std::ssize(loop);
    Triangles lid;
    const int part = part_of.at({loop[0], loop[1]});
    if (loop.size() == 3) {
      lid.emplace_back(Vector3i(loop[0], loop[2], loop[1]), part);
    } else {
      const int centre = surface.points.cols();
      surface.points.conservativeResize(3, centre + 1);
      surface.points.col(centre) = middle;
      for (std::size_t i = 0; i < loop.size(); ++i)
        lid.emplace_back(Vector3i(loop[(i + 1) % loop.size()], loop[i], centre), part);
    }
    double of_lid = 0.0;
    for (const auto& [t, unused] : lid) of_lid += area(surface, t);
    if (of_lid > left) {
      if (loop.size() > 3) surface.points.conservativeResize(3, surface.points.cols() - 1);
      continue;
    }
    left -= of_lid;
    ++done.holes;
    done.triangles += std::ssize(lid);
    triangles.insert(triangles.end(), lid.begin(), lid.end());
  }
}

bool in_range(const Surface& surface) {
  if (surface.triangles.cols() == 0 || !surface.points.allFinite()) return false;
  return surface.triangles.minCoeff() >= 0 && surface.triangles.maxCoeff() < surface.points.cols();
}

/// Whether each edge belongs to two triangles that turn opposite ways.
bool closed(const Surface& surface) {
  std::set<std::pair<int, int>> edges;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    for (int i = 0; i < 3; ++i)
      if (!edges.insert({surface.triangles(i, t), surface.triangles((i + 1) % 3, t)}).second) return false;
  }
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    return edges.contains({edge.second, edge.first});
  });
}

}  // namespace

Healing heal(Surface& surface) {
  Healing done;
  if (!in_range(surface)) return done;
  Triangles triangles = triangles_of(surface);
  const auto clean = [&] {
    done.duplicates += drop_duplicates(triangles);
    done.opposites += drop_opposites(triangles);
    done.slivers += split_at_slivers(surface, triangles);
    set_triangles(surface, triangles);
  };
  clean();
  if (triangles.empty()) return done;
  if ((done.cracks = close_cracks(surface)) > 0) {
    triangles = triangles_of(surface);
    clean();
  }
  done.flipped = make_consistent(surface);
  triangles = triangles_of(surface);
  close_holes(surface, triangles, done);
  set_triangles(surface, triangles);
  if (!closed(surface)) return done;
  done.cuts = mend_cuts(surface);
  done.shells = turn_outward(surface);
  return done;
}

}  // namespace thermotwin::mesh
