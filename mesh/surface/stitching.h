// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Cracks, and triangles that cut each other.

#include <Eigen/Core>

#include <utility>
#include <vector>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

using Triangles = std::vector<std::pair<Eigen::Vector3i, int>>;  ///< corners, part

Triangles triangles_of(const Surface& surface);

void set_triangles(Surface& surface, const Triangles& triangles);

/// Makes one corner of corners of open edges that are closer than the tolerance, and splits open edges at corners of
/// open edges that lie on them within it. Tolerances: 1e-6, 1e-5 and 1e-4 of the extent, while edges are open.
/// @return corners joined and edges split
int close_cracks(Surface& surface);

/// Drops triangles of one shell that cut each other, with more and more of their neighbours, and closes the gap flat.
/// Triangles of two shells stay for the check to name.
/// @return triangles dropped; 0 if cuts would remain
int mend_cuts(Surface& surface);

}  // namespace thermotwin::mesh
