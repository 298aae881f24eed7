// SPDX-License-Identifier: GPL-3.0-or-later
// Volumes, doors and coolant circuits from machine.toml.

#include "mesh/machine/coolant_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "mesh/machine/flow_network.h"
#include "mesh/machine/reader.h"

namespace thermotwin::mesh {

namespace reader {

using core::InputError;
using core::Node;

namespace {

VolumeSpec read_volume(const Node& node, Draft& draft) {
  VolumeSpec volume;
  volume.id = draft.define(node, "volume");
  if (node.has("content_l")) {
    refuse(node, "heat_capacity_J_K", "either heat_capacity_J_K or content_l");
    volume.capacity = scaled(node.uncertain("content_l", {1e-3, 1e7}),
                             1e-3 * node.number_or("density_kg_m3", 1000.0, {0.01, 30000.0}) *
                                 node.number_or("specific_heat_J_kgK", 4180.0, {10.0, 20000.0}));
  } else {
    for (const char* key : {"density_kg_m3", "specific_heat_J_kgK"}) refuse(node, key, "together with content_l");
    volume.capacity = node.uncertain("heat_capacity_J_K", {1e-3, 1e12});
  }
  for (const Node& part : node.tables("exchange")) {
    VolumeExchange exchange;
    exchange.with = draft.refer(part, "with", "ambient or volume");
    exchange.conductance = part.uncertain("conductance_W_K", {0.0, 1e9});
    exchange.state = part.text_or("state", "");
    if (!exchange.state.empty()) draft.references.push_back({"state channel", exchange.state, part.place("state")});
    if (exchange.with == volume.id)
      throw InputError(part.place("with"), "the volume itself", "an ambient, or another volume");
    part.finish();
    volume.exchanges.push_back(std::move(exchange));
  }
  node.finish();
  return volume;
}

void read_control(const Node& node, CoolantSpec& coolant) {
  coolant.controls_return = node.choice_or("controls", "outlet", {"outlet", "return"}) == "return";
  const std::string control = node.choice_or("control", "lag", {"lag", "two_point", "pi"});
  coolant.control = control == "pi"          ? ChillerControl::pi
                    : control == "two_point" ? ChillerControl::two_point
                                             : ChillerControl::lag;
  if (coolant.control == ChillerControl::lag && coolant.controls_return)
    throw InputError(node.place("controls"), "\"return\" with control = \"lag\"", "control = \"two_point\" or \"pi\"");
  if (coolant.control == ChillerControl::two_point) {
    coolant.band = node.number_or("band_K", coolant.band, core::positive);
    // An outlet that heads for a place inside the band would never switch.
    const core::Range beyond{coolant.controls_return ? 1e-3 : 0.5001 * coolant.band, 1e3};
    coolant.pull_down = node.number_or("pull_down_K", std::max(coolant.pull_down, coolant.band), beyond);
    coolant.drift_up = coolant.controls_return
                           ? node.number_or("drift_up_K", 0.0, {0.0, 1e3})
                           : node.number_or("drift_up_K", std::max(coolant.drift_up, coolant.band), beyond);
  } else {
    for (const char* key : {"band_K", "pull_down_K", "drift_up_K"}) refuse(node, key, "control = \"two_point\"");
  }
  if (coolant.control == ChillerControl::pi) {
    coolant.gain = node.number_or("gain", coolant.gain, {1e-6, 1e4});
    coolant.integral_time = node.number_or("integral_time_s", coolant.integral_time, {1e-3, 1e9});
    coolant.power = node.number_or("cooling_power_W", coolant.power, {1e-3, 1e9});
  } else {
    for (const char* key : {"gain", "integral_time_s", "cooling_power_W"}) refuse(node, key, "control = \"pi\"");
  }
}

CoolantSegment read_segment(const Node& part, const CoolantSpec& coolant, std::vector<std::string>& seen,
                            Draft& draft) {
  CoolantSegment segment;
  segment.id = part.text("id");
  core::require_unique_id(segment.id, part.place("id"), seen);
  segment.surface = draft.refer(part, "surface", "surface");
  segment.film_coefficient = part.uncertain("film_coefficient_W_m2K", {0.0, 1e6});
  segment.volume = part.number_or("volume_l", 0.5, {1e-6, 1e6}) * 1e-3;
  segment.cells = part.integer_or("cells", 1, 1, 100);
  segment.share = part.has("share") ? part.number("share", {1e-6, 1.0}) : std::nan("");
  if (part.has("after")) {
    segment.after = part.texts("after");
    if (segment.after == std::vector<std::string>{"chiller"}) segment.after.clear();
  } else if (!coolant.segments.empty()) {
    segment.after = {coolant.segments.back().id};
  }
  if (part.has("path_mm")) {
    const Eigen::MatrixX3d points = part.points3("path_mm");
    for (Eigen::Index i = 0; i < points.rows(); ++i) segment.path.push_back(points.row(i).transpose() * millimetre);
    double length = 0.0;
    for (std::size_t i = 1; i < segment.path.size(); ++i) length += (segment.path[i] - segment.path[i - 1]).norm();
    if (!(length > 1e-6))
      throw InputError(part.place("path_mm"), "a path of no length", "two or more points along the flow");
  }
  part.finish();
  return segment;
}

CoolantSpec read_coolant(const Node& node, Draft& draft) {
  CoolantSpec coolant;
  coolant.id = draft.define(node, "coolant");
  coolant.flow = node.uncertain("flow_kg_s", {1e-9, 1e4});
  coolant.specific_heat = node.number_or("specific_heat_J_kgK", coolant.specific_heat, {10.0, 20000.0});
  coolant.density = node.number_or("density_kg_m3", coolant.density, {0.01, 30000.0});
  coolant.guide_sensor = draft.refer_or_empty(node, "guide_sensor", "sensor");
  if (coolant.guide_sensor.empty()) {
    coolant.guide_ambient = node.text_or("guide_ambient", coolant.guide_ambient);
    draft.references.push_back(
        {"ambient", coolant.guide_ambient, node.has("guide_ambient") ? node.place("guide_ambient") : node.place()});
  } else {
    refuse(node, "guide_ambient", "either guide_sensor or guide_ambient");
  }
  coolant.guide_offset = node.number_or("guide_offset_K", 0.0, {-100.0, 100.0});
  coolant.inlet_offset = node.number_or("inlet_offset_K", 0.0, {-100.0, 100.0});
  coolant.guide_warmed_by = draft.refer_or_empty(node, "guide_warmed_by", "volume");
  if (coolant.guide_warmed_by.empty())
    refuse(node, "guide_warmed_share", "together with guide_warmed_by");
  else
    coolant.guide_warmed_share = node.number("guide_warmed_share", {0.0, 1.0});
  coolant.time_constant = node.number_or("time_constant_s", coolant.time_constant, {1e-3, 1e9});
  coolant.after_run = node.number_or("after_run_s", 0.0, {0.0, 1e7});
  coolant.standstill_stop = node.number_or("standstill_stop_s", 0.0, {0.0, 1e7});
  read_control(node, coolant);
  std::vector<std::string> seen{"chiller"};
  for (const Node& part : node.tables("segment")) coolant.segments.push_back(read_segment(part, coolant, seen, draft));
  if (coolant.segments.empty())
    throw InputError(node.place(), "a coolant without [[coolant.segment]]", "one or more segments, in order of flow");
  node.finish();
  flow_network(coolant, node.place());
  return coolant;
}

}  // namespace

void read_volumes(const Node& root, Draft& draft) {
  for (const Node& node : root.tables("volume")) draft.machine.volumes.push_back(read_volume(node, draft));
  for (const Node& node : root.tables("door")) {
    draft.machine.doors.push_back(draft.define(node, "door"));
    node.finish();
  }
}

void read_coolants(const Node& root, Draft& draft) {
  for (const Node& node : root.tables("coolant")) draft.machine.coolants.push_back(read_coolant(node, draft));
}

}  // namespace reader
}  // namespace thermotwin::mesh
