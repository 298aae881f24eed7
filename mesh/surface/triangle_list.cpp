// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/triangle_list.h"

#include <algorithm>
#include <iterator>
#include <set>

namespace thermotwin::mesh {

Triangles triangles_of(const Surface& surface) {
  Triangles triangles;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t)
    triangles.emplace_back(surface.triangles.col(t), surface.part[t]);
  return triangles;
}

void set_triangles(Surface& surface, const Triangles& triangles) {
  surface.triangles.resize(3, std::ssize(triangles));
  surface.part.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    surface.triangles.col(t) = triangles[t].first;
    surface.part[t] = triangles[t].second;
  }
}

void rename_corners(Triangles& triangles, const std::map<int, int>& becomes) {
  for (auto& [t, part] : triangles) {
    for (int& corner : t)
      if (const auto found = becomes.find(corner); found != becomes.end()) corner = found->second;
  }
  std::erase_if(triangles, [](const auto& t) {
    return t.first[0] == t.first[1] || t.first[1] == t.first[2] || t.first[2] == t.first[0];
  });
}

std::vector<OpenEdge> open_edges(const Triangles& triangles, std::vector<int>& corners) {
  std::map<std::pair<int, int>, std::pair<int, OpenEdge>> uses;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int a = triangles[t].first[i], b = triangles[t].first[(i + 1) % 3];
      auto& use = uses[std::minmax(a, b)];
      ++use.first;
      use.second = {a, b, t};
    }
  }
  std::vector<OpenEdge> open;
  std::set<int> ends;
  for (const auto& [edge, use] : uses) {
    if (use.first == 1) {
      open.push_back(use.second);
      ends.insert({edge.first, edge.second});
    }
  }
  corners.assign(ends.begin(), ends.end());
  return open;
}

}  // namespace thermotwin::mesh
