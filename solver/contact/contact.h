// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where two surfaces of non-matching meshes touch, at one axis position. Each slave triangle is cut by
// the master's triangles, projected onto its plane along its normal, as in mortar methods (Puso and
// Laursen 2004): to a piece belong one triangle of each side, and its quadrature is exact for the
// product of any two of their shape functions. Only what lies within reach along the slave's normal
// counts, and only pairs whose outward normals are more than 120 deg apart; of several layers of the
// master the nearest. The rim of the contact, and of the reach, is cut as exactly.

#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

/// @return the outer faces of a surface, and the mesh of its body; they belong to the machine's mesh
const std::vector<int>& faces_of(const mesh::MachineMesh& mesh, const std::string& surface);
const mesh::TetMesh& body_of(const mesh::MachineMesh& mesh, const std::string& surface);

struct ContactPoint {
  int slave_face, master_face;    ///< boundary triangles of the two bodies; master -1: ground
  Eigen::Vector3d slave_weights;  ///< barycentric on the slave triangle
  Eigen::Vector3d master_weights;
  double area;               ///< m^2, weight of the point
  Eigen::Vector3d position;  ///< m, on the slave, slave's home frame
  Eigen::Vector3d normal;    ///< of the slave there, slave's home frame
};

/// One joint at many positions: the search tree over the master is made once.
class ContactSearch {
public:
  /// @param mesh  must outlive the search
  ContactSearch(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint);
  ~ContactSearch();
  ContactSearch(ContactSearch&&) noexcept;

  /// Points of a pair of triangles stand together, those of a slave triangle too. May be called from
  /// several threads at once.
  /// @param slave_from_home, master_from_home  transformations of the two bodies at the pose
  std::vector<ContactPoint> at(const Eigen::Isometry3d& slave_from_home,
                               const Eigen::Isometry3d& master_from_home) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The same for one position.
std::vector<ContactPoint> find_contact(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint,
                                       const Eigen::Isometry3d& slave_from_home,
                                       const Eigen::Isometry3d& master_from_home);

}  // namespace thermotwin::solver
