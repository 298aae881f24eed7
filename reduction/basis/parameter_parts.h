// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Parts of a reduced model: the shares of single bodies, volumes, scales, screws and joints in its capacity matrix and
// its output rows, projected on its basis. One elastic factorisation of each body serves all parts. The part of a joint
// is the exact derivative of the output rows by ln k, the logarithm of its stiffness, from the system of the springs.

#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// @param basis  (size x r) of the reduced model
Parts make_parts(const solver::FullModel& full, const Eigen::MatrixXd& basis);

/// Parts of the model of order r: the leading r columns of all rows, and the leading r x r block of each capacity.
Parts truncated(const Parts& parts, Eigen::Index r);

/// Output rows at the poses that a reduced model stores, from rows of the full model times the basis at the same poses.
/// The table side is stored on the grid of the axes that carry the table. Joints held at more than three points bend
/// the common bed with every axis, so the table side changes with the other axes too (0.1 um of 100). At each tool pose
/// this remainder of the table side is subtracted from the tool side. The difference of both sides, the error, is then
/// exact.
ReducedOutputs stored_outputs(const mesh::Machine& machine, const std::vector<mesh::Pose>& tool_poses,
                              const std::vector<mesh::Pose>& table_poses,
                              const std::vector<solver::OutputRows>& at_tool,
                              const std::vector<solver::OutputRows>& at_table);

}  // namespace thermotwin::reduction
