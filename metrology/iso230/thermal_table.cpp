// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/iso230/thermal_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/statistics.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/iso230/scatter.h"

namespace thermotwin::metrology {

using compensation::ChannelKind;
using compensation::MeasuredChannel;
using compensation::Measurement;
using core::InputError;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double least_reliability = 0.1;  ///< of a temperature with a gradient
constexpr double sure = 3.0;               ///< standard deviations of the scatter's variance
constexpr double longest_gap = 3.0;        ///< between readings, over the median one, for a value between them

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

/// A temperature at the times of values.
struct Beside {
  VectorXd temperature;
  double scatter = 0;   ///< standard deviation, K
  double readings = 0;  ///< that it comes from: the rows between two of them scatter together
};

/// The temperature at the times of values that have none in their row, between its readings.
/// @param scatter  of a reading, K
Beside beside_values(const VectorXd& time, const VectorXd& values, const VectorXd& temperature, double scatter) {
  std::vector<Index> known;
  for (Index i = 0; i < temperature.size(); ++i)
    if (!std::isnan(temperature[i])) known.push_back(i);
  std::vector<double> gaps;
  for (std::size_t k = 1; k < known.size(); ++k) gaps.push_back(time[known[k]] - time[known[k - 1]]);
  Beside result{temperature, scatter, 1.0 * std::ssize(known)};
  if (gaps.empty()) return result;
  const double longest = longest_gap * core::median(gaps);
  double shares = 0.0;
  Index count = 0;
  std::set<Index> used;
  for (Index i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    double share = 1.0;  // of the scatter's variance
    if (!std::isnan(temperature[i])) {
      used.insert(i);
    } else {
      const auto next = std::lower_bound(known.begin(), known.end(), i);
      if (next == known.begin() || next == known.end()) continue;
      const Index low = *(next - 1), high = *next;
      if (time[high] - time[low] > longest) continue;
      const double weight = (time[i] - time[low]) / (time[high] - time[low]);
      result.temperature[i] = (1.0 - weight) * temperature[low] + weight * temperature[high];
      used.insert({low, high});
      share = weight * weight + (1.0 - weight) * (1.0 - weight);
    }
    shares += share;
    ++count;
  }
  if (count > 0) result.scatter *= std::sqrt(shares / (1.0 * count));
  result.readings = std::min<Index>(std::ssize(used), count);
  return result;
}

/// Slope over the temperature, whose values scatter, and its standard deviation (Fuller 1987, 1.2.3 with a known
/// variance of the scatter): with the residuals v = e - b w of the temperature's scatter w,
///   var b = (s_v^2 + (s_w^2 s_v^2 + b^2 s_w^4) / s_x^2) / (n s_x^2).
/// What comes from w is divided by the number of readings of the temperature instead of the n rows.
void find_gradient(const VectorXd& values, const Beside& beside, double uncertainty, ThermalRow& row) {
  const VectorXd& temperature = beside.temperature;
  const double scatter = beside.scatter, readings = beside.readings;
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
  const double count = about.size(), all = about.squaredNorm() / count,
               noise = scatter * scatter * (readings - 1.0) / readings, own = all - noise;
  row.reliability = own / all;
  if (row.reliability < least_reliability || own < sure * noise * std::sqrt(2.0 / readings)) return;
  row.gradient = about.dot(value) / count / own;
  const VectorXd residual = (value.array() - value.mean()).matrix() - row.gradient * about;
  const double by_scatter = std::pow(row.gradient * scatter, 2), least = uncertainty * uncertainty,
               variance = std::max(residual.squaredNorm() / (count - 2.0), least + by_scatter),
               rest = std::max(variance - by_scatter, least),
               more = (noise * variance + std::pow(row.gradient * noise, 2)) / own;
  row.gradient_std = std::sqrt((rest / count + (by_scatter + more) / readings) / own);
}

}  // namespace

ThermalTable thermal_table(const Measurement& measurement, const std::string& ambient) {
  ThermalTable table;
  const VectorXd time = measurement.time();
  table.duration = time[time.size() - 1] - time[0];
  table.ambient = ambient;
  VectorXd temperature;
  double scatter = 0.0;
  if (!ambient.empty()) {
    const MeasuredChannel& channel = temperature_named(measurement, ambient);
    temperature = measurement.values(channel);
    scatter = scatter_of(time, temperature, channel.uncertainty);
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
    std::vector<double> whole;
    Index first_hour = 0;
    for (Index i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;
      whole.push_back(values[i]);
      if (time[i] <= time[0] + core::units::hour) ++first_hour;
    }
    if (whole.size() < 2) {
      throw InputError(measurement.data.source + " " + channel.id, fmt::format("{} values", whole.size()),
                       "a displacement with at least 2 values");
    }
    ThermalRow row;
    row.channel = channel.id;
    row.unit = channel.unit;
    row.count = std::ssize(whole);
    row.last = whole.back() - whole.front();
    row.last_std = std::sqrt(2.0) * channel.uncertainty;
    const VectorXd all = Eigen::Map<VectorXd>(whole.data(), row.count);
    if (!table.has_an_hour() || first_hour < 2) first_hour = 0;
    const double noise = scatter_of(time, values, channel.uncertainty);
    const std::vector<RangeOfMotion> ranges =
        ranges_of_motion(all, {first_hour, row.count}, noise, channel.uncertainty);
    row.whole = ranges[1].range;
    row.motion = ranges[1].motion;
    row.motion_std = ranges[1].std;
    if (first_hour > 0) {
      row.first_hour = ranges[0].range;
      row.first_hour_motion = ranges[0].motion;
      row.first_hour_std = ranges[0].std;
    }
    if (temperature.size() > 0) {
      find_gradient(values, beside_values(time, values, temperature, scatter), channel.uncertainty, row);
    }
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) {
    throw InputError(measurement.folder.string(), "no displacement channel",
                     "at least one [[channel]] of kind displacement");
  }
  return table;
}

}  // namespace thermotwin::metrology
