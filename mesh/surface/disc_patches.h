// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A closed surface cut into discs that bend little. Each can be mapped onto the plane without folds, whatever the genus
// of the surface and however its sharp edges run.

#include <vector>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Patch of each triangle (0, 1, ...). Each patch is a topological disc whose rim passes no corner twice, crosses no
/// edge sharper than 40 deg, and holds normals within 50 deg of its first triangle's. The same surface gives the same
/// patches.
std::vector<int> disc_patches(const Surface& surface);

}  // namespace thermotwin::mesh
