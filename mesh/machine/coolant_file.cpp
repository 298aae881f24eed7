// SPDX-License-Identifier: GPL-3.0-or-later
// Volumes, doors and coolant circuits from machine.toml.

#include "mesh/machine/coolant_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "core/unique_id.h"
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
    volume.capacity_per_litre = 1e-3 * node.number("density_kg_m3") * node.number("specific_heat_J_kgK");
    volume.capacity = scaled(node.uncertain("content_l"), volume.capacity_per_litre);
  } else {
    for (const char* key : {"density_kg_m3", "specific_heat_J_kgK"}) refuse(node, key, "together with content_l");
    volume.capacity = node.uncertain("heat_capacity_J_K");
  }
  for (const Node& part : node.tables("exchange")) {
    VolumeExchange exchange;
    exchange.with = draft.refer(part, "with", "ambient or volume");
    exchange.conductance = part.uncertain("conductance_W_K");
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
  coolant.controls_return = node.choice("controls") == "return";
  const std::string control = node.choice("control");
  coolant.control = control == "pi"          ? ChillerControl::pi
                    : control == "two_point" ? ChillerControl::two_point
                                             : ChillerControl::lag;
  if (coolant.control == ChillerControl::lag && coolant.controls_return)
    throw InputError(node.place("controls"), "\"return\" with control = \"lag\"", "control = \"two_point\" or \"pi\"");
  if (coolant.control == ChillerControl::two_point) {
    coolant.band = node.number("band_K");
    // An outlet that heads for a place inside the band would never switch.
    const core::Range beyond{coolant.controls_return ? 1e-3 : 0.5001 * coolant.band, 1e3};
    coolant.pull_down = node.number_or("pull_down_K", std::max(coolant.pull_down, coolant.band), beyond);
    coolant.drift_up = coolant.controls_return
                           ? node.number_or("drift_up_K", 0.0)
                           : node.number_or("drift_up_K", std::max(coolant.drift_up, coolant.band), beyond);
  } else {
    for (const char* key : {"band_K", "pull_down_K", "drift_up_K"}) refuse(node, key, "control = \"two_point\"");
  }
  if (coolant.control == ChillerControl::pi) {
    coolant.gain = node.number("gain");
    coolant.integral_time = node.number("integral_time_s");
    coolant.power = node.number("cooling_power_W");
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
  segment.film_coefficient = part.uncertain("film_coefficient_W_m2K");
  segment.volume = part.number("volume_l") * 1e-3;
  segment.cells = part.integer("cells");
  segment.share = part.has("share") ? part.number("share") : std::nan("");
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
  coolant.flow = node.uncertain("flow_kg_s");
  coolant.specific_heat = node.number("specific_heat_J_kgK");
  coolant.density = node.number("density_kg_m3");
  coolant.guide_sensor = draft.refer_or_empty(node, "guide_sensor", "sensor");
  if (coolant.guide_sensor.empty()) {
    coolant.guide_ambient = node.text("guide_ambient");
    draft.references.push_back(
        {"ambient", coolant.guide_ambient, node.has("guide_ambient") ? node.place("guide_ambient") : node.place()});
  } else {
    refuse(node, "guide_ambient", "either guide_sensor or guide_ambient");
  }
  coolant.guide_offset = node.number("guide_offset_K");
  coolant.inlet_offset = node.number("inlet_offset_K");
  coolant.guide_warmed_by = draft.refer_or_empty(node, "guide_warmed_by", "volume");
  if (coolant.guide_warmed_by.empty())
    refuse(node, "guide_warmed_share", "together with guide_warmed_by");
  else
    coolant.guide_warmed_share = node.number("guide_warmed_share");
  coolant.time_constant = node.number("time_constant_s");
  coolant.after_run = node.number("after_run_s");
  coolant.standstill_stop = node.number("standstill_stop_s");
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
