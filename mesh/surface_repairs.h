// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The repairs that heal() is made of (surface_healing.h). Each returns how often it was needed.

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "mesh/import.h"

namespace thermotwin::mesh {

using Triangles = std::vector<std::pair<Eigen::Vector3i, int>>;  ///< corners, part

Triangles triangles_of(const Surface& surface);
void set_triangles(Surface& surface, const Triangles& triangles);

/// Makes one corner of corners of open edges that are closer than the tolerance, and splits open edges at corners of
/// open edges that lie on them within it. Tolerances: 1e-6, 1e-5 and 1e-4 of the extent, while edges are open.
/// @return corners joined and edges split
int close_cracks(Surface& surface);

/// Turns the smaller area of each connected sheet over, so that neighbours agree. A sheet on which they cannot stays.
/// @return triangles turned
int make_consistent(Surface& surface);

/// Turns outermost shells over whose normals point inwards, and those in them that do not turn as their depth asks.
/// Closed, consistent shells only.
/// @return shells turned
int turn_outward(Surface& surface);

/// Drops triangles of one shell that cut each other, with more and more of their neighbours, and closes the gap flat.
/// Triangles of two shells stay for the check to name.
/// @return triangles dropped; 0 if cuts would remain
int mend_cuts(Surface& surface);

/// Loops of edges that belong to one triangle only, in the direction of that triangle, that touch no other loop.
std::vector<std::vector<int>> holes_of(const Triangles& triangles);

inline constexpr std::size_t longest_hole = 12;
inline constexpr double largest_hole = 0.01;  ///< of the surface's area, all together

}  // namespace thermotwin::mesh
