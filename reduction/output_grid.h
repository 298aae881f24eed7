// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where the tool side's output rows are stored and how they are interpolated: at the workspace grid, quadratic in
// between; and along the line through the grid's middle along each linear axis at a pose more in each half. Along each
// line the difference of the cubic through five and the quadratic through three positions is added to the
// grid's interpolant: a Boolean sum (W. J. Gordon 1971), exact on the grid and on the lines, and for
// what each axis does beside what the others do.

#include <Eigen/Core>
#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::reduction {

/// The workspace grid, then, for each linear axis of three positions, the middle of each half with all other axes in
/// the middle of the grid. 33 poses for vmc5.
std::vector<mesh::Pose> tool_poses(const mesh::Machine& machine);

/// Weights of as many stored poses: the grid alone (as pose_weights of reduced_model.h), or all of tool_poses.
Eigen::VectorXd pose_weights(const mesh::Machine& machine, const mesh::Pose& pose, std::size_t stored);

}  // namespace thermotwin::reduction
