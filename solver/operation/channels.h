// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The input channels of a machine as a row of numbers: speeds, positions, powers, states, temperatures, each in the
// unit of its name. docs/reference/machine_channels.md lists the names. A row holds means over a time step.

#include <Eigen/Core>

#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::solver {

/// A value that nobody gives: the model then uses its own law or controller.
inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

/// Of a channel "axis.<id>.positive.on" where the direction of the last motion is unknown, or both are as frequent.
inline constexpr double either_direction = 0.5;

/// Channels of an axis; -1: clamped, no clamp; positive, no law asks for the direction of its last motion.
struct AxisChannels {
  int position, feed, low, high, clamped, positive;
  double unit;  ///< SI value of one unit of the position
};

class Channels {
public:
  explicit Channels(const mesh::Machine& machine);

  const std::vector<std::string>& names() const { return names_; }
  Eigen::Index size() const { return std::ssize(names_); }
  /// @return index of the channel, -1 if the machine has none of this name
  int index(const std::string& name) const;
  const AxisChannels& of_axis(std::size_t axis) const { return axes_[axis]; }

  /// Standing machine that is on: speeds 0, axes at home by either direction, ambients at default_C, coolants on,
  /// cutting fluid off; not_given for powers, coolant inlets and ranges (low, high).
  const Eigen::VectorXd& defaults() const { return defaults_; }

  /// Copies the given values into the row; where none is given (NaN), the row keeps its value. A range (low, high) that
  /// is not given anew becomes not_given once its axis stands (feed 0) or has a given position outside of the range.
  /// @param given, row  (size)
  void update(const Eigen::VectorXd& given, Eigen::Ref<Eigen::VectorXd> row) const;

private:
  std::vector<std::string> names_;
  std::vector<AxisChannels> axes_;
  std::unordered_map<std::string, int> index_;
  Eigen::VectorXd defaults_;
};

}  // namespace thermotwin::solver
