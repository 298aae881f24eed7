// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/channels.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/units.h"

namespace thermotwin::solver {

Channels::Channels(const mesh::Machine& machine) {
  std::vector<double> values;
  const auto add = [&](const std::string& name, double value) {
    if (!index_.try_emplace(name, names_.size()).second) return;
    names_.push_back(name);
    values.push_back(value);
  };
  add("machine.on", 1.0);
  add("spindle.speed_rpm", 0.0);
  for (const mesh::Axis& axis : machine.axes) {
    const std::string unit = axis.kind == mesh::AxisKind::linear ? "mm" : "deg";
    const std::string id = "axis." + axis.id + ".";
    // Home is the position 0, or the end of the travel next to it: as mesh::home_pose.
    const double to_unit = axis.kind == mesh::AxisKind::linear ? 1e3 : 180.0 / std::numbers::pi;
    const double home = axis.endless ? 0.0 : std::min(std::max(0.0, axis.low), axis.high);
    add(id + "position_" + unit, home * to_unit);
    add(id + "feed_" + unit + "_min", 0.0);
    add(id + "low_" + unit, not_given);
    add(id + "high_" + unit, not_given);
    if (machine.has_clamp(axis.id)) add(id + "clamp.on", 0.0);
    if (machine.has_direction(axis.id)) add(id + "positive.on", either_direction);
    axes_.push_back({index(id + "position_" + unit), index(id + "feed_" + unit + "_min"), index(id + "low_" + unit),
                     index(id + "high_" + unit), index(id + "clamp.on"), index(id + "positive.on"),
                     axis.kind == mesh::AxisKind::linear ? core::units::mm : core::units::deg});
  }
  // One that follows another has no temperature of its own until it is measured. A gradient that is not given is the
  // machine's.
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    add(ambient.id + ".T_C", ambient.follows.empty() ? ambient.default_C.value : not_given);
    if (ambient.has_gradient) add(ambient.id + ".gradient_K_m", not_given);
  }
  for (const mesh::VolumeSpec& volume : machine.volumes) add(volume.id + ".T_C", not_given);
  for (const std::string& door : machine.doors) add("door." + door + ".open", 0.0);
  add("cutting_fluid.on", 0.0);
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    add("coolant." + coolant.id + ".on", 1.0);
    add("coolant." + coolant.id + ".inlet_T_C", not_given);
  }
  for (const mesh::SourceSpec& source : machine.sources) {
    if (!source.drive.empty()) add(source.drive + ".power_W", not_given);
    for (const mesh::PowerLaw& law : source.laws)
      if (law.input.ends_with(".power_W")) add(law.input, not_given);
  }
  bool by_hour = machine.asks_time_of_day;
  for (const mesh::FilmSpec& film : machine.films) {
    if (film.table.input.ends_with(".power_W")) add(film.table.input, not_given);
    by_hour = by_hour || film.table.input == mesh::time_of_day;
  }
  for (const mesh::SourceSpec& source : machine.sources)
    for (const mesh::PowerLaw& law : source.laws) by_hour = by_hour || law.input == mesh::time_of_day;
  if (by_hour) add(mesh::time_of_day, not_given);
  defaults_ = Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

int Channels::index(const std::string& name) const {
  const auto at = index_.find(name);
  return at == index_.end() ? -1 : at->second;
}

void Channels::update(const Eigen::VectorXd& given, Eigen::Ref<Eigen::VectorXd> row) const {
  for (Eigen::Index k = 0; k < given.size(); ++k)
    if (!std::isnan(given[k])) row[k] = given[k];
  for (const AxisChannels& range : axes_) {
    const double slack = 1e-6 * (std::abs(row[range.low]) + std::abs(row[range.high]) + 1.0),
                 position = given[range.position];
    const bool ended =
        row[range.feed] == 0.0 || position < row[range.low] - slack || position > row[range.high] + slack;
    for (const int end : {range.low, range.high})
      if (ended && std::isnan(given[end])) row[end] = not_given;
  }
}

}  // namespace thermotwin::solver
