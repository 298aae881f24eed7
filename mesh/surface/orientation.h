// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Triangles and shells that turn the wrong way.

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Turns the smaller area of each connected sheet over, so that neighbours agree. A sheet on which they cannot stays.
/// @return triangles turned
int make_consistent(Surface& surface);

/// Turns outermost shells over whose normals point inwards, and those in them that do not turn as their depth asks.
/// Closed, consistent shells only.
/// @return shells turned
int turn_outward(Surface& surface);

}  // namespace thermotwin::mesh
