// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a machine's inputs can be, by its machine.toml: a spindle speed up to spindle_max_rpm, a feed up to the rapid of
// its axis, either in both directions, since losses follow their size (solver/operation/loss_laws.h), and a position or
// a range's end within the travel. What is not stated has no limit, an endless axis no position.

#include <limits>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

/// Of one channel, in its unit.
struct InputLimits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  double slack = 0;         ///< how far an overshoot or a rounded value may lie beyond
  bool both_ways = false;   ///< a speed: its sign is a direction
  std::string stated = {};  ///< the key of machine.toml

  /// Not of NaN, a missing value.
  bool passed_by(double value) const { return value < low - slack || value > high + slack; }
  /// The limit that the value has passed.
  double passed(double value) const { return value < low ? low : high; }
};

/// (channels)
std::vector<InputLimits> input_limits(const mesh::Machine& machine, const solver::Channels& channels);

}  // namespace thermotwin::compensation
