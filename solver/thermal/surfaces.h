// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Integrals over surfaces. Rows and columns are nodes of the machine.

#include <string>
#include <vector>

#include "mesh/machine_mesh.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/elements.h"

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

SparseMatrix from_triplets(Eigen::Index rows, Eigen::Index columns, const Triplets& triplets);

}  // namespace thermotwin::solver::assembly
