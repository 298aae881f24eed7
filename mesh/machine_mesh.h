// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The meshed machine: every body's mesh, its surfaces resolved to boundary triangles, the poses.

#include <Eigen/Geometry>

#include "mesh/machine.h"
#include "mesh/tet_mesh.h"

namespace thermotwin::mesh {

/// Axis positions, one per Machine::axes, m or rad.
using Pose = Eigen::VectorXd;

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
  double size_factor = 1.0;            ///< scales every element_size
  std::filesystem::path cache;         ///< folder for meshes already made; empty: none
};

/// Imports and meshes every body, in the machine's order, and resolves every surface.
/// @throws MeshError; InputError for a rule that matches nothing (with place and what is near)
MachineMesh build_machine_mesh(const Machine& machine, const MeshOptions& options);

/// "coarse", "standard", "fine", or a number. @throws InputError
double size_factor(const Machine& machine, const std::string& word);

/// Rigid transformation from a body's home frame to the machine frame at the pose.
Eigen::Isometry3d body_transform(const Machine& machine, int body, const Pose& pose);

/// All axes at 0 (clamped into their travel).
Pose home_pose(const Machine& machine);

/// The workspace grid, first axis slowest; axes outside the grid at home. 27 poses for vmc5.
std::vector<Pose> workspace_poses(const Machine& machine);

/// "X=-400,Y=0,B=45" (mm, deg) from a command line or file. @throws InputError
Pose parse_pose(const Machine& machine, const std::string& text, const std::string& place);
std::string format_pose(const Machine& machine, const Pose& pose);

/// Column names X_mm ... C_deg in the order of Machine::axes, and the values for a table.
std::vector<std::string> pose_columns(const Machine& machine);
Eigen::VectorXd pose_values(const Machine& machine, const Pose& pose);

}  // namespace thermotwin::mesh
