// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Slips of triangulated files that have one sensible repair: a triangle twice, a triangle without area between
// two corners and a third on the line between them, a hole of a few edges, a crack, two triangles back to back,
// triangles that turn the wrong way, a few triangles that cut each other.

#include <cstddef>
#include <string>
#include <vector>

#include "mesh/surface/surface.h"
#include "mesh/surface/triangle_list.h"

namespace thermotwin::mesh {

struct Healing {
  int duplicates = 0;  ///< triangles dropped that are there already, with the same direction
  int opposites = 0;   ///< pairs dropped that have the same corners and opposite directions
  int slivers = 0;     ///< triangles without area, given to the neighbour at their longest edge
  int cracks = 0;      ///< corners joined and edges split along open edges, up to 1e-4 of the extent
  int flipped = 0;     ///< triangles turned to agree with their neighbours
  int cuts = 0;        ///< triangles replaced because they cut each other, and neighbours of such
  int shells = 0;      ///< turned because their normals pointed inwards
  int holes = 0;       ///< closed: at most 12 edges, at most 1 % of the surface's area together
  int triangles = 0;   ///< added for them

  bool any() const { return duplicates + opposites + slivers + cracks + flipped + cuts + shells + holes > 0; }
  std::string brief() const;
};

/// Repairs what it can; what it cannot is left for check_surface to name.
/// @param surface  welded
Healing heal(Surface& surface);

/// Loops of edges that belong to one triangle only, in the direction of that triangle, that touch no other loop.
std::vector<std::vector<int>> holes_of(const Triangles& triangles);

inline constexpr std::size_t longest_hole = 12;
inline constexpr double largest_hole = 0.01;  ///< of the surface's area, all together

}  // namespace thermotwin::mesh
