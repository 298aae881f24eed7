// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A coarse picture of the machine's skin: boundary nodes that fall into one cell of a grid become one vertex, the node
// next to their mean (vertex clustering: Rossignac, Borrel 1993). Each vertex is a node of the mesh, so fields are
// taken there as they are. Nodes of faces, edges and corners, told by the normals around them, stay apart, and so do
// nodes without a connection within the cell: thin walls do not close, and edges stay straight and apart.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

struct Skin {
  Eigen::Matrix3Xd points;          ///< (3 x vertices) m, home frames of the bodies
  std::vector<Eigen::Index> nodes;  ///< (vertices) of the machine mesh
  Eigen::Matrix3Xi triangles;       ///< outward
  std::vector<Eigen::Index> first;  ///< (bodies + 1) first vertex of each body
  Eigen::Index vertices() const { return points.cols(); }
};

/// @param most  vertices of all bodies together, about
Skin make_skin(const mesh::MachineMesh& mesh, Eigen::Index most);

}  // namespace thermotwin::solver
