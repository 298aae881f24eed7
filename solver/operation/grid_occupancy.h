// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Weights of a joint's grid nodes, by where an axis spends its time.

#include "solver/operation/layout.h"

namespace thermotwin::solver {

/// Non-negative weights of the grid nodes, sum 1: hat functions at one position, or their mean over
/// an axis that spends its time evenly in [low, high].
Eigen::VectorXd grid_weights(const JointGrid& grid, double low, double high);

/// The same into a vector at hand.
/// @param low, high  range of the axis, m or rad, equal for a standing axis   @param weights  (nodes)
void grid_occupancy(const JointGrid& grid, double low, double high, Eigen::Ref<Eigen::VectorXd> weights);

}  // namespace thermotwin::solver
