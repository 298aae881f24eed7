// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where the tool side's output rows are stored and how they are interpolated: at the workspace grid, quadratic in
// between; and, for each linear axis of three positions, on the lines along it with all other axes at an end of
// theirs, at a pose more in each half. The difference of the cubic through five and the quadratic through three
// positions, straight between the lines, is added to the grid's interpolant: a Boolean sum (W. J. Gordon 1971),
// exact at all stored poses, for quadratics, and for a cubic of each axis that is linear in the others.

#include <Eigen/Core>
#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::reduction {

/// The workspace grid, then what lies between on the lines. 51 poses for vmc5.
std::vector<mesh::Pose> tool_poses(const mesh::Machine& machine);

/// Weights of as many stored poses: the grid alone (as pose_weights of reduced_model.h), or all of tool_poses.
Eigen::VectorXd pose_weights(const mesh::Machine& machine, const mesh::Pose& pose, std::size_t stored);

}  // namespace thermotwin::reduction
