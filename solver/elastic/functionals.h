// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Linear functionals of a body's displacement: the same numbers, read as a load, are the force that
// works on it. Pads, rigid motions of a surface, radial growth, a point on the skin.

#include <Eigen/Core>

#include <array>
#include <utility>
#include <vector>

#include "mesh/body/shape.h"
#include "mesh/body/triangle_tree.h"

namespace thermotwin::solver {

/// (degree of freedom 3 * node + direction, weight), rising, each at most once.
using Functional = std::vector<std::pair<Eigen::Index, double>>;

/// Sorts and adds up equal degrees of freedom.
void tidy(Functional& functional);

/// Sum of weight * u. @param displacement (3n) of the body
double evaluate(const Functional& functional, const Eigen::Ref<const Eigen::VectorXd>& displacement);

/// Least-squares rigid motion of a surface, weighted by nodal areas (the integrals of the shape
/// functions: of a quadratic triangle its edge nodes have a third each, its corners none): three translations at the
/// point (m), then three rotations (rad). @throws MeshError if the surface is a line or empty
std::array<Functional, 6> rigid_motion(const mesh::TetMesh& mesh, const std::vector<int>& faces,
                                       const Eigen::Vector3d& point, const std::string& surface);

/// Growth eps of u_r = eps r about an axis, least squares weighted by nodal areas; blind to
/// translations and, on a flat surface across the axis, to rotations. @param direction unit
Functional radial_growth(const mesh::TetMesh& mesh, const std::vector<int>& faces, const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction);

/// Interpolation at the point of the skin nearest to a place.
struct SkinPoint {
  mesh::FaceNodes node;  ///< 3, or 6 of a quadratic mesh
  mesh::FaceValues weight;
  double distance = 0;  ///< m, to the place
};
SkinPoint skin_point(const mesh::TetMesh& mesh, const mesh::TriangleTree& skin, const Eigen::Vector3d& place);
/// Displacement along a direction there.
Functional point_motion(const SkinPoint& point, const Eigen::Vector3d& direction);

}  // namespace thermotwin::solver
