// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The tool point that the nominal points of a record with positions of linear axes imply. In the frame of the tool at
// the stated axis positions, all nominal points have the same place. Points that contradict the positions have many
// places. Two tools of different lengths have two.

#include <Eigen/Core>

#include <string>

#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

struct ToolPlaces {
  Eigen::Index count = 0;                           ///< places further apart than 1 mm
  bool is_cut = false;                              ///< counting stopped at most_counted
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  ///< m, of the first point with all axes at 0
  std::string doubt;  ///< a warning: why the nominal points and the axis positions do not fit; empty: none
};

ToolPlaces tool_places(const RTestRecord& record);

/// Whether the points have positions of linear axes that move.
bool has_linear_positions(const RTestRecord& record);

}  // namespace thermotwin::metrology
