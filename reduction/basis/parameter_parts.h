// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Parts of a reduced model: what its capacity and its output rows owe to single bodies, scales, screws
// and joints, projected on its basis. Bodies' elastic factors serve all of them; the change with a
// joint's stiffness is an exact derivative of the springs' system.

#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// @param basis  (size x r) of the reduced model
Parts make_parts(const solver::FullModel& full, const Eigen::MatrixXd& basis);

/// The leading r columns (and rows of the capacities) of all.
Parts truncated(const Parts& parts, Eigen::Index r);

/// Rows at the poses that a reduced model stores, from those of the full model times its basis at
/// the same poses. What the table side does at a tool pose beyond what its own grid says goes to the
/// tool side: joints that are held at more than three points bend the common bed with every axis (0.1 um
/// of 100), and the difference of both sides, the error, is right.
ReducedOutputs stored_outputs(const mesh::Machine& machine, const std::vector<mesh::Pose>& tool_poses,
                              const std::vector<mesh::Pose>& table_poses,
                              const std::vector<solver::OutputRows>& at_tool,
                              const std::vector<solver::OutputRows>& at_table);

}  // namespace thermotwin::reduction
