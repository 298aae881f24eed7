// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Repair of a surface of which a few triangles cut each other.

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Drops triangles of one shell that cut each other, with more and more of their neighbours, and closes the gap flat.
/// Triangles of two shells stay for the check to name.
/// @return triangles dropped; 0 if cuts would remain
int mend_cuts(Surface& surface);

}  // namespace thermotwin::mesh
