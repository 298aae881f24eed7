// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where two surfaces of non-matching meshes touch, at one axis position: quadrature points on the
// slave's triangles, each with its closest point on the master, if that is within reach.

#include <Eigen/Core>
#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

struct ContactPoint {
  int slave_face, master_face;       ///< boundary triangles of the two bodies; master -1: ground
  Eigen::Vector3d slave_weights;     ///< barycentric on the slave triangle
  Eigen::Vector3d master_weights;
  double area;                       ///< m^2, weight of the point
  Eigen::Vector3d position;          ///< m, on the slave, slave's home frame
  Eigen::Vector3d normal;            ///< of the slave there, slave's home frame
};

/// @param slave_from_home, master_from_home  transformations of the two bodies at the pose
std::vector<ContactPoint> find_contact(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint,
                                       const Eigen::Isometry3d& slave_from_home,
                                       const Eigen::Isometry3d& master_from_home);

/// Grid of axis positions of a joint: spacing at most half the length of its shortest pad along a
/// linear axis; every 30 deg of a rotary one; travel ends and workspace positions are nodes.
std::vector<double> contact_grid(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint);

/// Pads: index of the connected set of slave triangles, divided by cells or sectors, per slave face
/// of the joint's surface; count in pads.
struct Pads {
  std::vector<int> of_face;          ///< parallel to MachineMesh::surfaces[slave]
  int count = 0;
};
/// Divides by face centres; a face belongs to one pad.
Pads find_pads(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint);

/// Connected sets of triangles (sharing a node), numbered by their first triangle: one number a face.
std::vector<int> connected_sets(const mesh::TetMesh& body, const std::vector<int>& faces);

}  // namespace thermotwin::solver
