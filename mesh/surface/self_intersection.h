// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Triangles of a surface that cut or cover each other.

#include <string>
#include <utility>
#include <vector>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Pairs of triangles that cut or cover each other, ascending, the smaller index first.
std::vector<std::pair<int, int>> cutting_triangles(const Surface& surface);

/// @throws MeshError at the first two triangles that cut or cover each other
void check_self_intersection(const Surface& surface, const std::string& body);

}  // namespace thermotwin::mesh
