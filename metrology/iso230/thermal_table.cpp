// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/iso230/thermal_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::metrology {

using compensation::ChannelKind;
using compensation::MeasuredChannel;
using compensation::Measurement;
using core::InputError;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

const MeasuredChannel& temperature_named(const Measurement& measurement, const std::string& id) {
  std::vector<std::string> known;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::temperature) continue;
    if (channel.id == id) return channel;
    known.push_back(channel.id);
  }
  // The temperature of an ambient goes by the ambient's name as well.
  for (const MeasuredChannel& channel : measurement.channels)
    if (channel.kind == ChannelKind::temperature && (channel.id == id + ".T_C" || channel.input == id + ".T_C"))
      return channel;
  throw InputError(measurement.folder.string(), "temperature channel '" + id + "'",
                   known.empty() ? "none: the record has no temperature"
                                 : "one of: " + core::join(known) + " (nearest: " + core::nearest(id, known) + ")");
}

double range_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

/// Slope over the temperature and its standard deviation.
void find_gradient(const VectorXd& values, const VectorXd& temperature, double uncertainty, ThermalRow& row) {
  std::vector<double> x, y;
  for (Index i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i]) || std::isnan(temperature[i])) continue;
    x.push_back(temperature[i]);
    y.push_back(values[i]);
  }
  if (x.size() < 3 || !(range_of(x) > 0.0)) return;
  const VectorXd at = Eigen::Map<VectorXd>(x.data(), std::ssize(x)),
                 value = Eigen::Map<VectorXd>(y.data(), std::ssize(y));
  const VectorXd about = at.array() - at.mean();
  row.gradient = about.dot(value) / about.squaredNorm();
  const VectorXd residual = (value.array() - value.mean()).matrix() - row.gradient * about;
  const double variance = std::max(residual.squaredNorm() / (std::ssize(x) - 2), uncertainty * uncertainty);
  row.gradient_std = std::sqrt(variance / about.squaredNorm());
}

}  // namespace

ThermalTable thermal_table(const Measurement& measurement, const std::string& ambient) {
  ThermalTable table;
  const VectorXd time = measurement.time();
  table.duration = time[time.size() - 1] - time[0];
  table.ambient = ambient;
  VectorXd temperature;
  if (!ambient.empty()) {
    temperature = measurement.values(temperature_named(measurement, ambient));
    std::vector<double> known;
    for (const double value : temperature)
      if (!std::isnan(value)) known.push_back(value);
    table.ambient_range = known.empty() ? 0.0 : range_of(known);
    if (!(table.ambient_range > 0.0)) {
      throw InputError(measurement.data.source + " " + ambient, "a temperature that does not change",
                       "a temperature with a range, for gradients per K");
    }
  }
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::displacement) continue;
    const VectorXd values = measurement.values(channel);
    std::vector<double> first_hour, whole;
    for (Index i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;
      whole.push_back(values[i]);
      if (time[i] <= time[0] + core::units::hour) first_hour.push_back(values[i]);
    }
    if (whole.size() < 2) {
      throw InputError(measurement.data.source + " " + channel.id, fmt::format("{} values", whole.size()),
                       "a displacement with at least 2 values");
    }
    ThermalRow row;
    row.channel = channel.id;
    row.unit = channel.unit;
    row.count = std::ssize(whole);
    if (table.has_an_hour() && !first_hour.empty()) row.first_hour = range_of(first_hour);
    row.whole = range_of(whole);
    row.last = whole.back() - whole.front();
    row.uncertainty = std::sqrt(2.0) * channel.uncertainty;
    if (temperature.size() > 0) find_gradient(values, temperature, channel.uncertainty, row);
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) {
    throw InputError(measurement.folder.string(), "no displacement channel",
                     "at least one [[channel]] of kind displacement");
  }
  return table;
}

}  // namespace thermotwin::metrology
