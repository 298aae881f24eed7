// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Poses (axis positions) and the body positions that follow from them.

#include <Eigen/Geometry>

#include <string>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Positions of all axes in the order of Machine::axes, m or rad.
using Pose = Eigen::VectorXd;

/// @return the rigid transformation from a body's home frame to the machine frame at the pose
Eigen::Isometry3d body_transform(const Machine& machine, int body, const Pose& pose);

/// @return all axes at 0, or at the nearest end of a travel without 0
Pose home_pose(const Machine& machine);

/// @return the poses of the workspace grid, the first axis slowest; axes outside the grid stand at home. vmc5 has 27
std::vector<Pose> workspace_poses(const Machine& machine);

/// Reads "X=-400,Y=0,B=45" (mm, deg); axes that are left out stand at home. @throws InputError (place)
Pose parse_pose(const Machine& machine, const std::string& text, const std::string& place);

/// @return the pose as parse_pose() reads it
std::string format_pose(const Machine& machine, const Pose& pose);

/// @return the column names X_mm ... C_deg in the order of Machine::axes
std::vector<std::string> pose_columns(const Machine& machine);

/// @return the values of these columns, mm or deg (axes)
Eigen::VectorXd pose_values(const Machine& machine, const Pose& pose);

}  // namespace thermotwin::mesh
