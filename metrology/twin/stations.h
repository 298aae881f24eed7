// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The poses at which the outputs of the full model are computed, and the weights that take them to a test's points.
// A discrete test has one for each of its poses. A sweep of one rotary axis has some along its arc: the outputs of tool
// and table, each in the frame of its body, are interpolated by cubic polynomials of the axis' position.

#include <Eigen/Core>

#include <utility>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "metrology/plan/test_plan.h"

namespace thermotwin::metrology {

struct Stations {
  std::vector<mesh::Pose> poses;
  /// (points) stations and weights, whose sum is 1
  std::vector<std::vector<std::pair<std::size_t, double>>> of_point;

  /// @return the index of this pose, added where it is none yet
  std::size_t add(const mesh::Machine& machine, const mesh::Pose& pose);
};

/// Above so many poses, a test has to be the sweep of one rotary axis.
inline constexpr std::size_t most_stations = 120;

/// @throws InputError: more poses than most_stations that are no sweep of one rotary axis
Stations stations_of(const mesh::Machine& machine, const std::vector<PlannedPoint>& points);

}  // namespace thermotwin::metrology
