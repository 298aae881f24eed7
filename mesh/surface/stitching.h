// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Cracks between the sheets of a surface.

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Makes one corner of corners of open edges that are closer than the tolerance, and splits open edges at corners of
/// open edges that lie on them within it. Tolerances: 1e-6, 1e-5 and 1e-4 of the extent, while edges are open.
/// @return corners joined and edges split
int close_cracks(Surface& surface);

}  // namespace thermotwin::mesh
