// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What one of a machine's channels counts, as its name says it (solver/operation/channels.h): read once, so that no
// model looks at the ends of names.

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

/// turning: of a spindle; range: the end of a travel that an axis swings in, blank while it stands; hour: of the day.
enum class Quantity { temperature, gradient, power, turning, feed, position, range, state, hour };

struct Channel {
  std::string name;
  Quantity quantity = Quantity::state;
  ChannelKind kind = ChannelKind::state;  ///< in a measurement
  std::string unit = "1";                 ///< in a measurement
  std::string axis;                       ///< id of the axis whose feed, position or range it is; else empty

  bool is_speed() const { return quantity == Quantity::turning || quantity == Quantity::feed; }
};

Channel channel_named(const std::string& name);
/// All of a machine, in their order.
std::vector<Channel> channels_of(const solver::Channels& channels);

}  // namespace thermotwin::compensation
