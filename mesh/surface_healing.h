// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Slips of triangulated files that have one sensible repair: a triangle twice, a triangle without area between
// two corners and a third on the line between them, a hole of a few edges.

#include <string>

#include "mesh/import.h"

namespace thermotwin::mesh {

struct Healing {
  int duplicates = 0;  ///< triangles dropped that are there already, with the same direction
  int slivers = 0;     ///< triangles without area, given to the neighbour at their longest edge
  int holes = 0;       ///< closed: at most 12 edges, at most 1 % of the surface's area together
  int triangles = 0;   ///< added for them

  bool any() const { return duplicates + slivers + holes > 0; }
  std::string brief() const;
};

/// Repairs what it can; what it cannot is left for check_surface to name.
/// @param surface  welded
Healing heal(Surface& surface);

}  // namespace thermotwin::mesh
