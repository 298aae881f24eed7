// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Convex polygons in a plane, corners counter-clockwise: cut by half planes (Sutherland and Hodgman
// 1974), area, and what one has beyond another. A polygon without area may have any number of corners.

#include <Eigen/Core>

#include <vector>

namespace thermotwin::mesh {

using Polygon = std::vector<Eigen::Vector2d>;

/// Keeps the part with line . (1, x, y) >= 0. @param spare  working space
void cut(Polygon& polygon, const Eigen::Vector3d& line, Polygon& spare);

double area(const Polygon& polygon);

/// Mean of the corners, which lies inside.
Eigen::Vector2d middle(const Polygon& polygon);

/// What both cover.
Polygon common_part(const Polygon& a, const Polygon& b);

/// What a covers and b does not, as convex polygons that do not overlap.
std::vector<Polygon> less(const Polygon& a, const Polygon& b);

}  // namespace thermotwin::mesh
