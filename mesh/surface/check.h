// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Whether a surface is closed, consistent and of a plausible size; its shells and pieces.

#include <string>
#include <vector>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Makes one node of corners closer than a millionth of the largest extent, drops triangles that
/// become lines by it. @return number of dropped triangles
int weld(Surface& surface);

/// Connected shell of each triangle (0, 1, ...). @param count  number of shells
std::vector<int> shells(const Surface& surface, int& count);

/// Each piece: an outer shell with the cavities in it, as a surface of its own.
/// @throws MeshError for a shell whose direction does not fit its depth ("inside out")
std::vector<Surface> pieces(const Surface& surface, const std::string& body);

/// m^3, from the divergence theorem; cavities count as such.
double enclosed_volume(const Surface& surface);

/// @param file  that the body is read from
/// @throws MeshError, naming body and file, unless the largest extent is within 1 mm .. 50 m
void check_extent(const Eigen::Matrix3Xd& points, const std::string& body, const std::string& file);

/// Turns of the surface around the point: +-1 inside, 0 outside (sum of solid angles / 4 pi).
double winding(const Surface& surface, const Eigen::Vector3d& point);

/// The triangles with take != 0 and their points.
Surface select(const Surface& surface, const std::vector<char>& take);

/// Holes, flipped or duplicate faces, self-intersection, a size that suggests a wrong unit (largest extent outside
/// 1 mm .. 50 m). @param file  that it is read from  @throws MeshError, naming body and triangle
void check_surface(const Surface& surface, const std::string& body, const std::string& file);

}  // namespace thermotwin::mesh
