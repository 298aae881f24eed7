// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Bodies that take part in heat only (screws): for the eye they move rigidly with the nearest
// elastic body that carries them, by a least-squares fit to its nodes beside them.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

struct CarriedBody {
  int body = -1, parent = -1;  ///< parent: elastic, or -1 where there is none
  Eigen::Index first_node = 0, parent_first = 0;
  Eigen::Matrix3Xd points;               ///< m, all nodes of the body
  std::vector<Eigen::Index> neighbours;  ///< nodes of the parent beside them, each once
  Eigen::Matrix3Xd neighbour_points;     ///< m
};

std::vector<CarriedBody> carried_bodies(const mesh::MachineMesh& mesh);

/// Fills the body's columns of displacement (3 x nodes of the machine) from its parent's.
void move_with_parent(const CarriedBody& body, const mesh::Machine& machine, const mesh::Pose& pose,
                      Eigen::Matrix3Xd& displacement);

}  // namespace thermotwin::solver
