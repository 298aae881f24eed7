// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How large the offsets of a machine get and how fast they change, from its reduced model. Its states are the
// surroundings
// 20 K off the reference, and what eight hours at each of the operating points that the basis is made from
// leave. With o the largest offset of both together anywhere in the workspace, the largest size is 2 o; a machine that
// stands may use it up in 300 s, the observer's own pace, and an axis that moves by dx adds
// 2 max |d offset / dx| |dx|,   the largest slope between neighbours of the workspace grid, dx at most rapid times
// time.
// The factor of 2 is for machines whose sources and films are not nominal, and for what the grid does not show.

#include <Eigen/Core>

#include "compensation/online/output_map.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// Time in which a standing machine's offsets get to where they are wanted, s.
inline constexpr double offset_settle_s = 300.0;

/// What a guard takes (offset_guard.h).
inline constexpr double largest_offset_um = 1e5, least_rate_um_s = 1e-6, largest_rate_um_s = 1e6;

struct OffsetLimits {
  double largest_um = 0;     ///< of the offset of an axis
  double rate_um_s = 0;      ///< while the axes stand
  Eigen::VectorXd slope_um;  ///< (axes of the machine) um per m or rad of motion
  Eigen::VectorXd rapid;     ///< (axes of the machine) m/s or rad/s
  /// How much further an offset may change because of a motion, um.
  double motion_um(const mesh::Pose& from, const mesh::Pose& to, double duration) const;
  /// The most an offset can change, um/s: all axes at rapid.
  double fastest_um_s() const { return rate_um_s + slope_um.dot(rapid); }
};

OffsetLimits offset_limits(const reduction::ReducedModel& model, const OutputMap& map);

}  // namespace thermotwin::compensation
