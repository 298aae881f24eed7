// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Shared by the files that assemble the heat of a machine: integrals over surfaces
// (thermal_surfaces.cpp) and joints at the positions of their grids (thermal_joints.cpp). Rows and
// columns are nodes of the machine.

#include <string>
#include <vector>

#include "mesh/machine_mesh.h"
#include "solver/operating_model.h"
#include "solver/thermal_elements.h"

namespace thermotwin::solver::assembly {

using Triplets = std::vector<Eigen::Triplet<double, int>>;

/// Faces of a surface with their global node numbers and areas.
struct FaceSet {
  const mesh::TetMesh* body;
  const std::vector<int>* faces;
  int first_node;
  double area;

  mesh::FaceNodes nodes(int face) const { return mesh::face_nodes(*body, face).array() + first_node; }
};

/// @throws InputError for a surface without area
FaceSet face_set(const mesh::MachineMesh& mesh, const std::string& id);

/// Adds the integral of N N^T over the surface.
void add_surface_mass(Triplets& triplets, const FaceSet& set, ElementRules rules = ElementRules::consistent);
/// Integral of N over the surface.
SparseColumn surface_load(const FaceSet& set);
/// Integral of N times the height above a level.
SparseColumn surface_height_load(const FaceSet& set, double level);
/// To the integral of N N^T what makes it that of (N - 1_f)(N - 1_f)^T: one fluid node on the other side.
void add_mixed(Triplets& triplets, const FaceSet& set, int fluid);

/// One joint at one grid node: its matrix, and where frictional heat of its two sides goes.
struct JointTerm {
  SparseMatrix matrix;
  double area = 0;
  SparseColumn slave_load, master_load;  ///< integrals of N over the area in contact
};

std::vector<JointGrid> joint_grids(const mesh::MachineMesh& mesh);

/// The joints at all nodes of their grids, in parallel. @param rules  for those with the ground, which
/// are films   @param size  of the system
/// @throws InputError for a joint that touches nowhere
std::vector<std::vector<JointTerm>> joint_terms(const mesh::MachineMesh& mesh, const std::vector<JointGrid>& grids, ElementRules rules,
                                                Eigen::Index size);

/// Frictional heat of one W at a joint: shares of both sides, sum 1 whatever the contact area is.
SparseColumn joint_source(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint, const mesh::SourcePlace& place,
                          const JointTerm& term);

SparseMatrix from_triplets(Eigen::Index rows, Eigen::Index columns, const Triplets& triplets);

}  // namespace thermotwin::solver::assembly
