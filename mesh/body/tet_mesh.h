// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A tetrahedral mesh of one body with its boundary triangles and named groups of them. Linear
// tetrahedra, or quadratic ones with a node in the middle of each edge; edges are straight in both.
// Lengths in m, in the frame that the body has at the home position of all axes.

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

namespace thermotwin::mesh {

using Matrix6Xi = Eigen::Matrix<int, 6, Eigen::Dynamic>;

/// Corners of the edges of a tetrahedron and of a triangle, in the order of edge nodes below (the
/// order of VTK and Abaqus).
inline constexpr int tet_edge[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
inline constexpr int face_edge[3][2] = {{0, 1}, {1, 2}, {2, 0}};

struct TetMesh {
  Eigen::Matrix3Xd points;                         ///< (3 x nodes) m
  Eigen::Matrix4Xi tets;                           ///< (4 x elements) corner nodes, positive volume
  Matrix6Xi tet_edges;                             ///< (6 x elements) edge nodes; no columns: linear
  Eigen::Matrix3Xi faces;                          ///< (3 x boundary triangles) corner nodes, outward orientation
  Eigen::Matrix3Xi face_edges;                     ///< (3 x boundary triangles) edge nodes; no columns: linear
  Eigen::VectorXi face_tet;                        ///< (boundary triangles) the element behind each
  std::map<std::string, std::vector<int>> groups;  ///< named sets of boundary triangles
  int solids = 0;  ///< closed volumes of the CAD or surface file; 0: made from a mesh file

  Eigen::Index nodes() const { return points.cols(); }
  Eigen::Index elements() const { return tets.cols(); }
  Eigen::Index face_count() const { return faces.cols(); }
  int order() const { return tet_edges.cols() > 0 ? 2 : 1; }

  double volume(Eigen::Index element) const;             ///< m^3
  double face_area(Eigen::Index face) const;             ///< m^2
  Eigen::Vector3d face_normal(Eigen::Index face) const;  ///< unit, outward
  Eigen::Vector3d face_centre(Eigen::Index face) const;  ///< m
  double total_volume() const;                           ///< m^3
};

/// Builds faces, face_edges and face_tet from the elements (triangles that belong to one element
/// only), outward. Group contents given as sets of node triples may be attached by find_faces.
/// @throws MeshError naming the element, if one is inverted, flat or has a repeated node, if a
///         node belongs to no element, or a triangle to more than two
void build_boundary(TetMesh& mesh, const std::string& body);

/// Makes the mesh linear (1) or quadratic (2). Promotion keeps all nodes and puts new ones after
/// them, in the middle of each edge; demotion drops edge nodes. Faces and groups stay as they are.
void set_order(TetMesh& mesh, int order);

/// Index of the boundary triangle with these nodes in any order, per column; -1 where none.
std::vector<int> find_faces(const TetMesh& mesh, const Eigen::Matrix3Xi& triangles);

/// Quality of the elements: 1 for the regular tetrahedron (mean ratio measure
/// 12 (3V)^(2/3) / sum of squared edge lengths).
struct Quality {
  double minimum = 0, mean = 0;
  double below_0_1_percent = 0;                ///< share of elements below 0.1
  double shortest_edge = 0, longest_edge = 0;  ///< m
};
Quality quality(const TetMesh& mesh);

}  // namespace thermotwin::mesh
