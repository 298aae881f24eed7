// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The meshed machine: the mesh of every body, and the boundary triangles of every surface.

#include <Eigen/Geometry>

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

struct MachineMesh {
  Machine machine;
  std::vector<TetMesh> bodies;             ///< one per Machine::bodies
  std::vector<Eigen::Index> first_node;    ///< (bodies + 1) offsets into the global node numbers
  std::vector<std::vector<int>> surfaces;  ///< one per Machine::surfaces: boundary triangles

  Eigen::Index nodes() const { return first_node.back(); }
  const TetMesh& body_of_surface(int surface) const;
  double surface_area(int surface) const;  ///< m^2
};

struct MeshOptions {
  double size_factor = 1.0;     ///< scales every element_size
  std::filesystem::path cache;  ///< folder for meshes already made; empty: none
  void validate() const;        ///< @throws InputError
};

/// Imports and meshes every body, in the machine's order, and resolves every surface.
/// @throws MeshError; InputError for a rule that matches nothing (with place and what is near)
MachineMesh build_machine_mesh(const Machine& machine, const MeshOptions& options);

/// "coarse", "standard", "fine", or a number. @throws InputError
double size_factor(const Machine& machine, const std::string& word);

}  // namespace thermotwin::mesh
