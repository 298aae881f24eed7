// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// As grid_weights of operating_model.h, into a vector at hand.

#include "solver/operating_model.h"

namespace thermotwin::solver {

/// @param low, high  range of the axis, m or rad, equal for a standing axis  @param weights (nodes)
void grid_occupancy(const JointGrid& grid, double low, double high, Eigen::Ref<Eigen::VectorXd> weights);

}  // namespace thermotwin::solver
