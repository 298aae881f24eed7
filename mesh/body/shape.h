// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Shape functions of tetrahedra and triangles of order 1 and 2 in barycentric coordinates L,
//   order 1: N_i = L_i;   order 2: N_i = L_i (2 L_i - 1), N_ij = 4 L_i L_j on the edge i-j,
// corners first, then edges in the order of tet_edge and face_edge; and quadrature rules with
// positive weights. Edges are straight, so that L is linear in space whatever the order.
// Rules: 4 points of degree 2 and 7 points of degree 5 (Radon) are in closed form; 14 points of
// degree 5 on the tetrahedron after Walkington (2000).

#include <Eigen/Core>

#include <vector>

#include "mesh/body/tet_mesh.h"

namespace thermotwin::mesh {

using TetNodes = Eigen::Matrix<int, Eigen::Dynamic, 1, 0, 10, 1>;
using FaceNodes = Eigen::Matrix<int, Eigen::Dynamic, 1, 0, 6, 1>;
using TetValues = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 10, 1>;
using FaceValues = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using TetSlopes = Eigen::Matrix<double, Eigen::Dynamic, 4, 0, 10, 4>;
using TetGradients = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 10, 3>;

/// All nodes of an element (4 or 10) or a boundary triangle (3 or 6), in the order of the values.
TetNodes tet_nodes(const TetMesh& mesh, Eigen::Index element);
FaceNodes face_nodes(const TetMesh& mesh, Eigen::Index face);

TetValues tet_shape(int order, const Eigen::Vector4d& at);
FaceValues face_shape(int order, const Eigen::Vector3d& at);
/// dN/dL, one row a node; times barycentric_gradients() it is the gradient in space.
TetSlopes tet_slopes(int order, const Eigen::Vector4d& at);

/// Gradients of L in space, 1/m, one row a corner; the same everywhere in the element.
Eigen::Matrix<double, 4, 3> barycentric_gradients(const TetMesh& mesh, Eigen::Index element);

/// Barycentric coordinates of a point of space in an element; outside it one is negative.
Eigen::Vector4d barycentric(const TetMesh& mesh, Eigen::Index element, const Eigen::Vector3d& point);
/// ... and of a point in the plane of a boundary triangle.
Eigen::Vector3d face_barycentric(const TetMesh& mesh, Eigen::Index face, const Eigen::Vector3d& point);

struct TetPoint {
  Eigen::Vector4d at;
  double share;  ///< of the volume; all shares add to 1
};
struct FacePoint {
  Eigen::Vector3d at;
  double share;  ///< of the area
};
/// Rules that are exact up to the degree (at most 5).
const std::vector<TetPoint>& tet_rule(int degree);
const std::vector<FacePoint>& face_rule(int degree);

}  // namespace thermotwin::mesh
