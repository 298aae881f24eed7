// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/channel.h"

namespace thermotwin::compensation {

namespace {

/// The first ending that fits counts.
struct Ending {
  const char* text;
  Quantity quantity;
  ChannelKind kind;
  const char* unit;
};
constexpr Ending endings[] = {{"_mm_min", Quantity::feed, ChannelKind::speed, "mm_min"},
                              {"_deg_min", Quantity::feed, ChannelKind::speed, "deg_min"},
                              {"_rpm", Quantity::turning, ChannelKind::speed, "rpm"},
                              {"_mm", Quantity::position, ChannelKind::position, "mm"},
                              {"_deg", Quantity::position, ChannelKind::position, "deg"},
                              {"T_C", Quantity::temperature, ChannelKind::temperature, "degC"},
                              {"_W", Quantity::power, ChannelKind::power, "W"},
                              {"gradient_K_m", Quantity::gradient, ChannelKind::state, "K/m"},
                              {"day.time_h", Quantity::hour, ChannelKind::state, "h"}};

}  // namespace

Channel channel_named(const std::string& name) {
  Channel channel;
  channel.name = name;
  for (const Ending& ending : endings) {
    if (!name.ends_with(ending.text)) continue;
    channel.quantity = ending.quantity;
    channel.kind = ending.kind;
    channel.unit = ending.unit;
    break;
  }
  // axis.<id>.<what>; an id may hold dots itself.
  const std::string before = "axis.";
  const std::size_t what = name.rfind('.');
  if (!name.starts_with(before) || what < before.size()) return channel;
  channel.axis = name.substr(before.size(), what - before.size());
  const bool swings = name.compare(what, 5, ".low_") == 0 || name.compare(what, 6, ".high_") == 0;
  if (channel.quantity == Quantity::position && swings) channel.quantity = Quantity::range;
  return channel;
}

std::vector<Channel> channels_of(const solver::Channels& channels) {
  std::vector<Channel> all;
  for (const std::string& name : channels.names()) all.push_back(channel_named(name));
  return all;
}

}  // namespace thermotwin::compensation
