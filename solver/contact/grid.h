// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Axis positions at which a joint is integrated, and the pads that hold it.

#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

/// Grid of axis positions of a joint: spacing at most half the length of the shortest connected part of its slave along
/// a linear axis; every 30 deg of a rotary one; travel ends and workspace positions are nodes.
std::vector<double> contact_grid(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint);

/// Pads: index of the connected set of slave triangles, divided by cells or sectors, per slave face
/// of the joint's surface; count in pads.
struct Pads {
  std::vector<int> of_face;  ///< parallel to MachineMesh::surfaces[slave]
  int count = 0;
};

/// Divides by face centres; a face belongs to one pad.
Pads find_pads(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint);

/// Connected sets of triangles (sharing a node), numbered by their first triangle: one number a face.
std::vector<int> connected_sets(const mesh::TetMesh& body, const std::vector<int>& faces);

}  // namespace thermotwin::solver
