// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The place of a sphere on the table and the poses at which the tool point meets it: the linear axes that bring the
// tool there while the rotary axes stand where they are asked to.

#include <Eigen/Core>

#include <map>
#include <string>

#include "mesh/machine/kinematic_chain.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::metrology {

/// The sphere's centre in the table's home frame.
/// @param radius   m, from the table's axis  @param azimuth  rad, about it, from x (y where the axis is along x)
/// @param height   m, above tcp.table_point along the axis
Eigen::Vector3d sphere_on_table(const mesh::Machine& machine, double radius, double azimuth, double height);

/// The sphere's centre in the machine frame.
Eigen::Vector3d sphere_at(const mesh::Machine& machine, const mesh::Pose& pose, const Eigen::Vector3d& sphere_in_table);

/// The pose with these rotary positions at which the tool point meets the sphere. The travel is not checked.
/// @throws InputError (place) where the linear axes do not reach all directions
mesh::Pose pose_on_sphere(const mesh::Machine& machine, const mesh::Pose& rotary,
                          const Eigen::Vector3d& sphere_in_table, const std::string& place);

/// The chain of the key kinematic_chain with the directions and origins of the machine's axes.
/// @throws InputError: no chain, an axis that it lacks or that lies in another direction
mesh::KinematicChain chain_of(const mesh::Machine& machine);

/// Positions by axis id, as chains have them.
std::map<std::string, double> positions_of(const mesh::Machine& machine, const mesh::Pose& pose);

}  // namespace thermotwin::metrology
