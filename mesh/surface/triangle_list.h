// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The triangles of a surface as a list that repairs change, and the edges that one triangle only has.

#include <Eigen/Core>

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

using Triangles = std::vector<std::pair<Eigen::Vector3i, int>>;  ///< corners, part

Triangles triangles_of(const Surface& surface);

void set_triangles(Surface& surface, const Triangles& triangles);

/// Replaces corners by others, and drops triangles that have a corner twice then.
void rename_corners(Triangles& triangles, const std::map<int, int>& becomes);

struct OpenEdge {
  int from, to;
  std::size_t triangle;
};

/// Edges that one triangle only has, and their corners in ascending order.
std::vector<OpenEdge> open_edges(const Triangles& triangles, std::vector<int>& corners);

}  // namespace thermotwin::mesh
