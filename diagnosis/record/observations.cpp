// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/observations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "compensation/measurement/measurement_check.h"
#include "core/error.h"
#include "core/range.h"
#include "core/statistics.h"
#include "diagnosis/record/model_steps.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::diagnosis {

using compensation::ChannelKind;
using compensation::MeasuredChannel;
using compensation::Measurement;
using core::InputError;
using Eigen::Index;

namespace {

/// Adds factor times the straight-line value at a time to the weights of a row.
void add_weight(std::vector<ObservedChannel::Weight>& weights, const Eigen::VectorXd& points, Index row, double time,
                double factor) {
  const double* first = points.data();
  const double* last = first + points.size();
  Index right = std::upper_bound(first, last, time) - first;
  right = std::clamp<Index>(right, 1, points.size() - 1);
  const double share = (time - points[right - 1]) / (points[right] - points[right - 1]);
  if (share < 1.0) weights.push_back({row, right - 1, factor * (1.0 - share)});
  if (share > 0.0) weights.push_back({row, right, factor * share});
}

ObservedChannel average_channel(const MeasuredChannel& channel, const Eigen::VectorXd& time,
                                const Eigen::VectorXd& values, const Observations& grid) {
  ObservedChannel result;
  result.channel = channel;
  std::vector<double> times, means, counts;
  Index first_sample = -1;
  for (Index i = 0; i < time.size();) {
    auto at = std::min(static_cast<Index>((time[i] - grid.start) / grid.interval), grid.intervals - 1);
    double end = grid.start + grid.interval * (at + 1);
    // The quotient may round down to the interval before.
    if (time[i] >= end && at + 1 < grid.intervals) end = grid.start + grid.interval * (++at + 1);
    double sum = 0.0, sum_time = 0.0;
    std::vector<Index> used;
    for (; i < time.size() && (time[i] < end || at == grid.intervals - 1); ++i) {
      if (!std::isfinite(values[i])) continue;
      if (first_sample < 0) first_sample = i;
      // The sample that defines the zero says nothing about the machine.
      if (channel.zero == compensation::Zero::first && i == first_sample) continue;
      sum += values[i];
      sum_time += time[i];
      used.push_back(i);
    }
    if (used.empty()) continue;
    const double n = used.size();
    const auto row = std::ssize(means);
    for (const Index k : used) add_weight(result.weights, grid.points, row, time[k], 1.0 / n);
    if (channel.zero == compensation::Zero::first)
      add_weight(result.weights, grid.points, row, time[first_sample], -1.0);
    result.interval.push_back(at);
    times.push_back(sum_time / n);
    means.push_back(sum / n);
    counts.push_back(n);
    if (times.back() < grid.split) result.fitted = row + 1;
  }
  const auto n = std::ssize(means);
  result.time = Eigen::Map<Eigen::VectorXd>(times.data(), n);
  result.value = Eigen::Map<Eigen::VectorXd>(means.data(), n);
  result.samples = Eigen::Map<Eigen::VectorXd>(counts.data(), n);
  // A zero is what the channel showed first, whether or not the file was shifted to it.
  if (channel.zero == compensation::Zero::first && first_sample >= 0) result.value.array() -= values[first_sample];
  return result;
}

Index interval_at(double time, const Observations& grid) {
  return std::min(static_cast<Index>((time - grid.start) / grid.interval), grid.intervals - 1);
}

/// A coolant's return jumps within seconds when its pump starts or stops, and rows say only about when: means that
/// touch a switch are left out. @param on  (rows) state of the pump
void leave_out_switches(const Eigen::VectorXd& time, const Eigen::VectorXd& on, const Observations& grid,
                        Eigen::VectorXd& values) {
  std::set<Index> touched;
  for (Index i = 1; i < time.size(); ++i) {
    if (on[i] == on[i - 1]) continue;
    for (Index k = interval_at(time[i - 1], grid); k <= interval_at(time[i], grid); ++k) touched.insert(k);
  }
  for (Index i = 0; i < time.size(); ++i)
    if (touched.count(interval_at(time[i], grid)) > 0) values[i] = std::nan("");
}

/// Uniform start: mean of the first readings of all temperature channels.
void find_start(const Measurement& measurement, const mesh::Machine& machine, const Eigen::VectorXd& first_row,
                const solver::Channels& channels, Observations& out) {
  std::vector<double> first;
  const Eigen::VectorXd time = measurement.time();
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::temperature || channel.sensor.empty()) continue;
    const Eigen::VectorXd values = measurement.values(channel);
    for (Index i = 0; i < values.size() && time[i] <= time[0] + out.interval; ++i) {
      if (std::isfinite(values[i])) {
        // What the sensor itself is known to add is no temperature.
        first.push_back(values[i] - machine.sensors[machine.sensor_index(channel.sensor)].offset);
        break;
      }
    }
  }
  if (first.empty()) {
    const int air = channels.index("air.T_C");
    out.start_C = air >= 0 && std::isfinite(first_row[air]) ? first_row[air] : machine.reference_C;
    out.start_spread_K = out.start_second_K = 1.0;
    return;
  }
  // The median: one sensor that is off should not move the start of all others.
  out.start_C = core::quantile(first, 0.5);
  std::vector<double> distance;
  for (const double value : first) distance.push_back(std::abs(value - out.start_C));
  std::sort(distance.begin(), distance.end());
  if (distance.size() > 1) out.start_second_K = distance[distance.size() - 2];
  out.start_spread_K = 1.4826 * core::median(std::move(distance));
}

}  // namespace

Eigen::MatrixXd ObservedChannel::means(const Eigen::MatrixXd& at_points) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size(), at_points.cols());
  for (const Weight& weight : weights) result.row(weight.row) += weight.value * at_points.row(weight.point);
  return result;
}

Index Observations::size() const {
  Index total = 0;
  for (const ObservedChannel& channel : channels) total += channel.size();
  return total;
}

Eigen::VectorXd Observations::stacked() const {
  Eigen::VectorXd all(size());
  Index at = 0;
  for (const ObservedChannel& channel : channels) {
    all.segment(at, channel.size()) = channel.value;
    at += channel.size();
  }
  return all;
}

double split_between(const Observations& of, double heldout_share) {
  constexpr double least_fitted = 4.0;
  return of.start +
         of.interval *
             std::max(least_fitted, std::floor((1.0 - heldout_share) * (of.end - of.start) / of.interval + 1e-9));
}

void ObserveOptions::validate() const {
  core::require_option(interval_s > 0, "observe interval_s", interval_s, "a positive number of seconds");
  core::require_option(heldout_share >= 0 && heldout_share < 1, "observe heldout_share", heldout_share,
                       "0 to less than 1");
  core::require_option(longest_step_s > 0, "observe longest_step_s", longest_step_s, "a positive number of seconds");
  core::require_option(most_intervals >= 8, "observe most_intervals", most_intervals, "8 or more");
}

Observations observe(const Measurement& measurement, const mesh::Machine& machine, const solver::Channels& channels,
                     const ObserveOptions& options) {
  options.validate();
  const std::string place = measurement.folder.string();
  const Eigen::VectorXd time = measurement.time();
  if (time.size() < 2)
    throw InputError(place, fmt::format("{} rows of data", time.size()), "a record of several intervals of time");
  Observations out;
  out.start = time[0];
  out.end = time[time.size() - 1];
  const double duration = out.end - out.start;
  out.interval = std::max(options.interval_s, duration / options.most_intervals);
  out.intervals = std::max<Index>(1, static_cast<Index>(std::ceil(duration / out.interval - 1e-9)));
  out.split = split_between(out, options.heldout_share);
  if (out.intervals < 8) {
    throw InputError(place, fmt::format("a record of {:.0f} s", duration),
                     fmt::format("at least 8 intervals of {:.0f} s, so that a part can be held out", out.interval));
  }
  const Eigen::MatrixXd rows = compensation::channel_rows(measurement, channels);
  set_model_steps(measurement, channels, rows, options, out);
  find_start(measurement, machine, rows.row(0).transpose(), channels, out);
  for (const MeasuredChannel& channel : measurement.channels) {
    const bool temperature = channel.kind == ChannelKind::temperature && !channel.sensor.empty();
    if (!temperature && channel.kind != ChannelKind::displacement) continue;
    Eigen::VectorXd values = measurement.values(channel);
    if (const int sensor = temperature ? machine.sensor_index(channel.sensor) : -1; sensor >= 0) {
      const std::string& coolant = machine.sensors[sensor].return_of;
      const int on = coolant.empty() ? -1 : channels.index("coolant." + coolant + ".on");
      if (on >= 0) leave_out_switches(time, rows.col(on), out, values);
    }
    ObservedChannel observed = average_channel(channel, time, values, out);
    if (!temperature) {
      observed.pose = channel.pose_text.empty() ? mesh::home_pose(machine)
                                                : mesh::parse_pose(machine, channel.pose_text, "channel " + channel.id);
    }
    if (observed.fitted >= 4)
      out.channels.push_back(std::move(observed));
    else
      out.left_out.push_back(channel.id);
  }
  if (out.channels.empty()) {
    throw InputError(place, "no channel of kind temperature (with sensor) or displacement with data",
                     "one or more such channels in channels.toml");
  }
  return out;
}

}  // namespace thermotwin::diagnosis
