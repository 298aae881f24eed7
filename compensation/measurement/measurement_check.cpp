// SPDX-License-Identifier: GPL-3.0-or-later
// A measurement seen from a machine: does it fit, and what drives the model.

#include "compensation/measurement/measurement_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/measurement/channel.h"
#include "compensation/measurement/measurement.h"
#include "core/error.h"
#include "core/text.h"
#include "core/toml_place.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;

void check_sensor(const std::string& place, const MeasuredChannel& channel, const mesh::Machine& machine) {
  if (machine.sensor_index(channel.sensor) < 0) {
    std::vector<std::string> known;
    for (const mesh::SensorSpec& sensor : machine.sensors) known.push_back(sensor.id);
    throw InputError(place, "unknown sensor '" + channel.sensor + "'",
                     known.empty()
                         ? "no sensor: machine " + machine.name + " has none"
                         : "one of: " + core::join(known) + " (nearest: " + core::nearest(channel.sensor, known) + ")");
  }
  if (channel.kind != ChannelKind::temperature || channel.unit != "degC") {
    throw InputError(place, "unit '" + channel.unit + "' of sensor '" + channel.sensor + "'",
                     "kind temperature in degC");
  }
}

void check_input(const std::string& place, const MeasuredChannel& channel, const solver::Channels& channels) {
  if (channels.index(channel.input) < 0 && channel.input != mesh::time_of_day) {
    throw InputError(place, "unknown input '" + channel.input + "'",
                     "a channel of the machine (nearest: " + core::nearest(channel.input, channels.names()) + ")");
  }
  const std::string unit = channel_named(channel.input).unit;
  if (channel.unit != unit)
    throw InputError(place, "unit '" + channel.unit + "' of input '" + channel.input + "'", "'" + unit + "'");
}

/// "X0C": the axis C of a location error; "T" of the table; empty: it is none.
std::string located(const std::string& quantity) {
  const bool located = quantity.size() == 3 && quantity[1] == '0' &&
                       (std::string("XYZABC").find(quantity[0]) != std::string::npos || quantity == "R0T");
  return located ? quantity.substr(2) : "";
}

void check_displacement(const std::string& place, const MeasuredChannel& channel, const mesh::Machine& machine) {
  static const std::vector<std::string> errors = {"dx", "dy", "dz", "ra", "rb", "rc"};
  const std::string axis = located(channel.quantity);
  if (axis.empty() && std::find(errors.begin(), errors.end(), channel.quantity) == errors.end()) {
    throw InputError(place,
                     channel.quantity.empty() ? std::string("no quantity") : "quantity '" + channel.quantity + "'",
                     "what the model predicts at a pose, one of: " + core::join(errors) +
                         ", or a location error such as X0C, A0B, Z0T, R0T");
  }
  if (!axis.empty() && axis != "T") {
    const int index = machine.axis_index(axis);
    if (index < 0 || machine.axes[index].kind != mesh::AxisKind::rotary) {
      throw InputError(place, "quantity '" + channel.quantity + "' on machine " + machine.name,
                       "errors of rotary axes that it has, or of the table (T)");
    }
  }
  mesh::parse_pose(machine, channel.pose_text, place + " pose");
  for (std::size_t i = 0; i < channel.points.size(); ++i) {
    mesh::parse_pose(machine, channel.points[i].pose_text,
                     fmt::format("{} arrangement '{}' point {}", place, channel.arrangement, i + 1));
  }
}

constexpr Eigen::Index few = 3, hundred = 100;  ///< fault codes that are blanked: so many, or one of so many

std::string column_text(const MeasuredChannel& channel) {
  return fmt::format("column {} '{}'", channel.column + 1, channel.id);
}

/// Of a channel in degC, rows with a temperature that cannot be.
std::vector<Eigen::Index> implausible_rows(const Measurement& measurement, const MeasuredChannel& channel,
                                           const mesh::PlausibleRange& range) {
  std::vector<Eigen::Index> rows;
  if (channel.unit != "degC") return rows;
  const auto values = measurement.data.values.col(channel.column);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (!std::isnan(values[i]) && !range.holds(values[i])) rows.push_back(i);
  return rows;
}

}  // namespace

namespace {

/// A temperature rise along a coolant segment, which virtual measurements may record; no model of the machine reads it.
bool is_coolant_rise(const MeasuredChannel& channel, const mesh::Machine& machine) {
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    for (const mesh::CoolantSegment& segment : coolant.segments)
      if (channel.id == "coolant." + coolant.id + "." + segment.id + ".rise") return true;
  }
  return false;
}

}  // namespace

void require_recorded_on(const Measurement& measurement, const std::string& machine, const std::string& of) {
  if (measurement.machine.empty() || machine.empty() || measurement.machine == machine) return;
  throw InputError((measurement.folder / "channels.toml").string() + " [record] machine",
                   "'" + measurement.machine + "'", "'" + machine + "', the machine of " + of);
}

void require_fits(const Measurement& measurement, const mesh::Machine& machine) {
  require_recorded_on(measurement, machine.name, machine.path.empty() ? "the model" : machine.path.string());
  const solver::Channels channels(machine);
  std::vector<std::string> ids;
  for (const MeasuredChannel& channel : measurement.channels) ids.push_back(channel.id);
  const std::vector<std::string> places =
      core::toml_places_of_ids(measurement.folder / "channels.toml", "channel", ids);
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const MeasuredChannel& channel = measurement.channels[k];
    const std::string& place = places[k];
    if (!channel.sensor.empty()) {
      check_sensor(place, channel, machine);
    } else if (!channel.input.empty()) {
      check_input(place, channel, channels);
    } else if (channel.kind == ChannelKind::displacement) {
      check_displacement(place, channel, machine);
    } else if (!is_coolant_rise(channel, machine)) {
      throw InputError(place, "neither sensor nor input nor quantity",
                       "sensor, input or quantity: what the channel is on the machine");
    }
  }
  require_plausible(measurement, machine.plausible_range());
}

void require_plausible(const Measurement& measurement, const mesh::PlausibleRange& range) {
  for (const MeasuredChannel& channel : measurement.channels) {
    const std::vector<Eigen::Index> rows = implausible_rows(measurement, channel, range);
    if (rows.empty()) continue;
    range.require(
        measurement.data.values(rows.front(), channel.column),
        fmt::format("{}:{} {}", measurement.data.source, core::Table::line_of_row(rows.front()), column_text(channel)));
  }
}

std::vector<std::string> blank_implausible(Measurement& measurement, const mesh::PlausibleRange& range) {
  std::vector<std::string> blanked;
  for (const MeasuredChannel& channel : measurement.channels) {
    const std::vector<Eigen::Index> rows = implausible_rows(measurement, channel, range);
    auto values = measurement.data.values.col(channel.column);
    const Eigen::Index all = (!values.array().isNaN()).count(), wrong = std::ssize(rows);
    if (wrong == 0 || wrong > std::max(few, all / hundred) || 2 * wrong >= all) continue;
    blanked.push_back(
        fmt::format("{}: {}: {} of {} values outside {}, the first {:.9g} degC at {:.9g} s (line {}); taken as missing",
                    measurement.data.source, column_text(channel), wrong, all, range.phrase(), values[rows.front()],
                    measurement.data.values(rows.front(), 0), core::Table::line_of_row(rows.front())));
    for (const Eigen::Index row : rows) values[row] = std::numeric_limits<double>::quiet_NaN();
  }
  require_plausible(measurement, range);
  return blanked;
}

namespace {

/// A clock that begins anew at midnight runs on, and through rows without it: means over midnight are midnight.
void run_on(const Eigen::VectorXd& time, Eigen::Ref<Eigen::VectorXd> hours) {
  constexpr double day = 24.0;
  Eigen::Index last = 0;
  while (last < hours.size() && !std::isfinite(hours[last])) ++last;
  if (last == hours.size()) return;
  const auto since = [&](Eigen::Index i) { return hours[last] + (time[i] - time[last]) / core::units::hour; };
  for (Eigen::Index i = 0; i < last; ++i) hours[i] = since(i);
  for (Eigen::Index i = last + 1; i < hours.size(); ++i) {
    if (std::isfinite(hours[i]))
      hours[i] += day * std::round((since(i) - hours[i]) / day);
    else
      hours[i] = since(i);
    last = i;
  }
}

}  // namespace

Eigen::MatrixXd channel_rows(const Measurement& measurement, const solver::Channels& channels) {
  const Eigen::Index n = measurement.data.rows();
  Eigen::MatrixXd rows = Eigen::MatrixXd::Constant(n, channels.size(), solver::not_given);
  for (const MeasuredChannel& channel : measurement.channels) {
    if (const int index = channel.input.empty() ? -1 : channels.index(channel.input); index >= 0)
      rows.col(index) = measurement.data.values.col(channel.column);
  }
  if (const int hour = channels.index(mesh::time_of_day); hour >= 0) {
    if (std::isfinite(measurement.starts_at_h) && !rows.col(hour).array().isFinite().any())
      rows.col(hour) = measurement.starts_at_h + measurement.time().array() / core::units::hour;
    run_on(measurement.time(), rows.col(hour));
  }
  Eigen::VectorXd held = channels.defaults();
  for (Eigen::Index i = 0; i < n; ++i) {
    channels.update(rows.row(i).transpose(), held);
    rows.row(i) = held.transpose();
  }
  return rows;
}

bool tells_time_of_day(const Measurement& measurement) {
  return std::isfinite(measurement.starts_at_h) ||
         std::any_of(measurement.channels.begin(), measurement.channels.end(),
                     [](const MeasuredChannel& channel) { return channel.input == mesh::time_of_day; });
}

}  // namespace thermotwin::compensation
