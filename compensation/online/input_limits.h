// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Limits of the input channels, from machine.toml: a spindle speed up to spindle_max_rpm, a feed up to the rapid of its
// axis, both in either direction, and a position or an end of a range within the travel. An overshoot of 1 % is
// allowed. A channel without a stated value has no limit, nor has the position of an endless axis.

#include <limits>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

/// Limits of one channel, in its unit.
struct InputLimits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  double slack = 0;         ///< allowed excess, for overshoot and rounded values
  bool both_ways = false;   ///< a speed: its sign is a direction
  std::string stated = {};  ///< the key of machine.toml

  /// @return whether the value exceeds a limit; false for NaN (missing)
  bool passed_by(double value) const { return value < low - slack || value > high + slack; }
  /// @return the limit that the value exceeds
  double passed(double value) const { return value < low ? low : high; }
};

/// @return the limits of all channels, (channels)
std::vector<InputLimits> input_limits(const mesh::Machine& machine, const solver::Channels& channels);

}  // namespace thermotwin::compensation
