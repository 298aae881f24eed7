// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Axis positions, and where they put the bodies.

#include <Eigen/Geometry>

#include <string>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Axis positions, one per Machine::axes, m or rad.
using Pose = Eigen::VectorXd;

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
