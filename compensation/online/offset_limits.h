// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Limits of size and rate of a machine's offsets, from its reduced model. The states considered are surroundings 20 K
// off the reference, and eight hours at each of the operating points that the basis is made from. With o the largest
// offset of both together anywhere in the workspace, the limit of the size is 2 o. A standing machine may reach it in
// 300 s, the pace of the observer, and an axis that moves by dx adds
//   2 max |d offset / dx| |dx|,
// the largest slope between neighbours of the workspace grid, with dx at most rapid times time. The factor 2 allows for
// sources and films that are not nominal, and for the offsets between the grid's poses.

#include <Eigen/Core>

#include <vector>

#include "compensation/online/output_map.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// Time in which the offsets of a standing machine reach their limit, s.
inline constexpr double offset_settle_s = 300.0;

/// Limits for a guard (offset_guard.h).
inline constexpr double largest_offset_um = 1e5, least_rate_um_s = 1e-6, largest_rate_um_s = 1e6;

struct OffsetLimits {
  double largest_um = 0;     ///< of the offset of an axis
  double rate_um_s = 0;      ///< while the axes stand
  Eigen::VectorXd slope_um;  ///< (axes of the machine) um per m or rad of motion
  Eigen::VectorXd rapid;     ///< (axes of the machine) m/s or rad/s
  /// @return the further change of an offset that a motion allows, um
  double motion_um(const mesh::Pose& from, const mesh::Pose& to, double duration) const;
  /// @return the fastest change of an offset, um/s, with all axes at rapid
  double fastest_um_s() const { return rate_um_s + slope_um.dot(rapid); }
};

/// @return the states after eight hours at each operating point, from the reference, (order) K each
std::vector<Eigen::VectorXd> worked_states(const reduction::ReducedModel& model);

OffsetLimits offset_limits(const reduction::ReducedModel& model, const OutputMap& map);

}  // namespace thermotwin::compensation
