// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/input_limits.h"

#include <cstddef>

namespace thermotwin::compensation {
namespace {

constexpr double overshoot = 0.01;  ///< of the largest speed or of the travel

InputLimits speed_limits(double fastest, const std::string& stated) {
  InputLimits limits;
  limits.both_ways = true;
  if (!(fastest > 0.0)) return limits;
  limits.low = -fastest;
  limits.high = fastest;
  limits.slack = overshoot * fastest;
  limits.stated = stated;
  return limits;
}

}  // namespace

std::vector<InputLimits> input_limits(const mesh::Machine& machine, const solver::Channels& channels) {
  std::vector<InputLimits> all(channels.size());
  all[channels.index("spindle.speed_rpm")] = speed_limits(machine.spindle_max_rpm, "spindle_max_rpm");
  for (std::size_t a = 0; a < machine.axes.size(); ++a) {
    const mesh::Axis& axis = machine.axes[a];
    const solver::AxisChannels& of_axis = channels.of_axis(a);
    const std::string unit = axis.kind == mesh::AxisKind::linear ? "mm" : "deg", of = " of axis " + axis.id;
    all[of_axis.feed] = speed_limits(axis.rapid / of_axis.unit * 60.0, "rapid_" + unit + "_min" + of);
    if (axis.endless) continue;
    const double low = axis.low / of_axis.unit, high = axis.high / of_axis.unit;
    for (const int channel : {of_axis.position, of_axis.low, of_axis.high})
      all[channel] = {low, high, overshoot * (high - low), false, "travel_" + unit + of};
  }
  return all;
}

}  // namespace thermotwin::compensation
