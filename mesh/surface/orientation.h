// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Repairs the orientation of triangles (order of their corners) and of closed shells.

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Makes neighbouring triangles agree. In each connected sheet the part with the smaller area is reversed; a sheet that
/// is not orientable stays as it is. @return triangles reversed
int make_consistent(Surface& surface);

/// Reverses outermost shells whose normals point inwards. Within such a shell it also reverses those of wrong
/// orientation: normals point outwards at even depth and inwards at odd depth (cavities). All shells have to be
/// consistent; if one has a hole, nothing changes. @return shells reversed
int turn_outward(Surface& surface);

}  // namespace thermotwin::mesh
