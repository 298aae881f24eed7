// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/observations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "compensation/measurement/channel.h"
#include "compensation/measurement/measurement_check.h"
#include "compensation/measurement/stretch.h"
#include "core/error.h"
#include "core/interpolation.h"
#include "core/range.h"
#include "core/statistics.h"
#include "diagnosis/record/diagnose_options.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::diagnosis {

using compensation::Channel;
using compensation::ChannelKind;
using compensation::MeasuredChannel;
using compensation::Measurement;
using compensation::Quantity;
using core::InputError;
using Eigen::Index;

namespace {

constexpr double unchanged = 5e-3;  ///< relative: speeds and positions that count as standing still

/// Powers and temperatures enter linearly and may be averaged, and so may times; speeds, positions and states may not.
std::vector<bool> averageable(const std::vector<Channel>& channels) {
  std::vector<bool> result;
  for (const Channel& channel : channels)
    result.push_back(channel.quantity == Quantity::temperature || channel.quantity == Quantity::power ||
                     channel.quantity == Quantity::hour);
  return result;
}

bool same_operation(const Eigen::RowVectorXd& a, const Eigen::RowVectorXd& b, const std::vector<bool>& average) {
  for (Index c = 0; c < a.size(); ++c) {
    if (std::isfinite(a[c]) != std::isfinite(b[c])) return false;
    if (!std::isfinite(a[c]) || average[c]) continue;
    if (std::abs(a[c] - b[c]) > unchanged * std::max(std::abs(a[c]), std::abs(b[c])) + 1e-9) return false;
  }
  return true;
}

/// A time in which nothing changes that may not be averaged.
struct Span {
  double begin, end;
  Eigen::RowVectorXd row;
};

/// Joins sample intervals of equal operation up to the longest and divides longer ones.
std::vector<Span> equal_spans(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows, double longest,
                              const std::vector<bool>& average) {
  std::vector<Span> spans;
  for (Index i = 0; i + 1 < time.size();) {
    Index j = i + 1;
    Eigen::RowVectorXd sum = rows.row(i) * (time[j] - time[i]);
    while (j + 1 < time.size() && time[j + 1] - time[i] <= longest * (1 + 1e-9) &&
           same_operation(rows.row(i), rows.row(j), average)) {
      sum += rows.row(j) * (time[j + 1] - time[j]);
      ++j;
    }
    const double span = time[j] - time[i];
    const auto pieces = std::max<Index>(1, static_cast<Index>(std::ceil(span / longest - 1e-9)));
    const auto end_of = [&](Index k) { return k >= pieces ? time[j] : time[i] + span * k / pieces; };
    for (Index k = 0; k < pieces; ++k) spans.push_back({end_of(k), end_of(k + 1), sum / span});
    i = j;
  }
  return spans;
}

/// Mean over a step; what is not measured in all of it is what was.
Eigen::RowVectorXd mean_row(const std::vector<Span>& spans, std::size_t first, std::size_t last) {
  if (last - first == 1) return spans[first].row;
  Eigen::RowVectorXd mean = spans[first].row;
  for (Index c = 0; c < mean.size(); ++c) {
    double sum = 0.0, weight = 0.0;
    for (std::size_t i = first; i < last; ++i) {
      if (!std::isfinite(spans[i].row[c])) continue;
      sum += (spans[i].end - spans[i].begin) * spans[i].row[c];
      weight += spans[i].end - spans[i].begin;
    }
    if (weight > 0.0) mean[c] = sum / weight;
  }
  return mean;
}

constexpr double gap_intervals = 1.5;    ///< usual intervals that make a gap
constexpr double pause_intervals = 4.5;  ///< and those of a pause: more than a few rows are not missing by chance
constexpr double changed_share = 0.05;   ///< of the largest value
constexpr double switched_rows = 0.1;    ///< what changes in more rows is no switch
constexpr double short_gap = 0.5;        ///< of a long row: a row so soon after another says when, too
constexpr double least_part = 0.02;      ///< of a while, which a row keeps
constexpr std::size_t most_uncertain_changes = 24;
constexpr double parts_after_switch[] = {0.2, 0.5};  ///< of a step, where the one after a switch is split
constexpr double shortest_split_step_s = 60;

/// A speed, power or state, and its largest value in the record.
struct Watched {
  Index channel;
  double largest;
};

/// Largest change of one of them from row to row, as a share of its largest value.
double change_between(const Eigen::RowVectorXd& a, const Eigen::RowVectorXd& b, const std::vector<Watched>& watched) {
  double change = 0.0;
  for (const Watched& w : watched) {
    if (const double difference = std::abs(b[w.channel] - a[w.channel]) / w.largest; std::isfinite(difference))
      change = std::max(change, difference);
  }
  return change;
}

std::vector<Watched> watched_channels(const Eigen::MatrixXd& rows, const std::vector<Channel>& channels) {
  std::vector<Watched> watched;
  for (Index c = 0; c < rows.cols(); ++c) {
    const Quantity quantity = channels[c].quantity;
    if (quantity == Quantity::temperature || quantity == Quantity::position || quantity == Quantity::range ||
        quantity == Quantity::hour)
      continue;  // wander, or are elsewhere in every row
    double largest = 0.0;
    for (const double value : rows.col(c))
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
    if (largest > 0.0) watched.push_back({c, largest});
  }
  return watched;
}

/// Those that change now and then, and not with every row; powers are averaged.
std::vector<Watched> switched_channels(const Eigen::MatrixXd& rows, const std::vector<Watched>& watched,
                                       const std::vector<bool>& average) {
  std::vector<Watched> switched;
  for (const Watched& w : watched) {
    const auto values = rows.col(w.channel);
    Index changes = 0;
    for (Index i = 0; i + 1 < values.size(); ++i)
      changes += std::abs(values[i + 1] - values[i]) >= changed_share * w.largest;  // not of NaN
    if (!average[w.channel] && changes <= switched_rows * rows.rows()) switched.push_back(w);
  }
  return switched;
}

/// Parts that are short, since an axis is logged where it happens to be, go into one step; what is switched now and
/// then ends it: heat is not in proportion to a pump that runs for a part of the time. A step after a switch is short,
/// for beside a source temperatures rise with the root of time, and values between points lie on straight lines.
void make_steps(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows, double longest,
                const std::vector<bool>& average, const std::vector<Watched>& switched, Observations& out) {
  const std::vector<Span> all = equal_spans(time, rows, longest, average);
  const auto may_change = [&](double at) {
    return std::any_of(out.may_hold.begin(), out.may_hold.end(),
                       [at](const auto& may) { return std::abs((may.earlier ? may.to : may.from) - at) < 1e-6; });
  };
  const auto switches_at = [&](std::size_t i) {
    return i == 0 || change_between(all[i - 1].row, all[i].row, switched) >= changed_share;
  };
  std::vector<double> points = {time[0]};
  std::vector<Eigen::RowVectorXd> means;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t last = i + 1;
    while (last < all.size() && all[last].end - all[i].begin <= longest * (1 + 1e-9) && !switches_at(last) &&
           !may_change(all[last].begin))
      ++last;
    const double begin = all[i].begin, span = all[last - 1].end - begin;
    for (std::size_t k = i; k < last && last - i > 1; ++k)
      out.mixed[std::ssize(means)].push_back({(all[k].end - all[k].begin) / span, all[k].row.transpose()});
    if (last - i == 1 && switches_at(i) && span > shortest_split_step_s) {
      for (const double part : parts_after_switch) {
        points.push_back(begin + part * span);
        means.push_back(all[i].row);
      }
    }
    points.push_back(all[last - 1].end);
    means.push_back(mean_row(all, i, last));
    i = last;
  }
  out.points = Eigen::Map<Eigen::VectorXd>(points.data(), std::ssize(points));
  out.rows.resize(std::ssize(means), rows.cols());
  for (Index i = 0; i < out.rows.rows(); ++i) out.rows.row(i) = means[i];
}

/// The time of day runs on between rows and through a pause: that of a step is that of its middle.
void set_hours(const Eigen::VectorXd& time, const Eigen::VectorXd& hours, Index channel, Observations& out) {
  if (!hours.array().isFinite().all()) return;
  for (Index s = 0; s < out.rows.rows(); ++s) {
    const double hour = core::linear_at(time, hours, 0.5 * (out.points[s] + out.points[s + 1]));
    out.rows(s, channel) = hour;
    if (const auto mixed = out.mixed.find(s); mixed != out.mixed.end())
      for (Observations::Part& part : mixed->second) part.row[channel] = hour;
  }
}

/// From when on the inputs of each row hold. Where a few rows are missing, what changed did so somewhere in the gap,
/// half way for the model; else as the row says, or up to an interval before; or when it is known to have come. Through
/// a pause longer than an
/// interval and a few rows the row before it holds as it says, or for a part of it: more rows may be lost than a few.
Eigen::VectorXd input_times(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows,
                            const std::vector<Watched>& watched, const std::vector<bool>& average,
                            const std::map<double, double>& changes, bool rows_at_changes, Observations& out) {
  const Index n = time.size();
  const double usual = compensation::usual_interval(time);
  Eigen::VectorXd result = time;
  std::vector<std::pair<double, std::vector<Observations::MayHold>>> found;
  for (Index i = 0; i + 2 < n; ++i) {  // what the last row says holds for nothing
    const double shown = time[i + 1], gap = shown - time[i];
    const bool of_a_row = gap <= gap_intervals * usual;
    if (of_a_row && rows_at_changes) continue;
    const bool of_a_pause = gap > std::max(out.interval, pause_intervals * usual);
    if (of_a_row && (usual <= long_row_s || gap <= short_gap * long_row_s)) continue;
    const double change = change_between(rows.row(i), rows.row(i + 1), watched);
    if (change < changed_share) continue;
    // What wanders is what it was; where an axis swings changes with its feed.
    Eigen::VectorXd after = rows.row(i + 1).transpose(), before = rows.row(i).transpose();
    for (Index c = 0; c < after.size(); ++c) {
      if (average[c] && std::none_of(watched.begin(), watched.end(), [c](const Watched& w) { return w.channel == c; }))
        std::swap(after[c], before[c]);
    }
    const double first = of_a_row ? time[i] : shown - (gap - usual), nearest = first + least_part * (shown - first);
    const auto known = changes.find(shown);
    const double came = known != changes.end()   ? std::clamp(known->second, nearest, shown)
                        : of_a_row || of_a_pause ? shown
                                                 : 0.5 * (first + shown);
    result[i + 1] = came;
    // Anywhere alike: the mean square of how far it is off, shared by two tangents of opposite sign.
    const double a = came - first, b = shown - came,
                 std = std::sqrt((a * a * a + b * b * b) / (3.0 * (a + b) * (a * a + b * b)));
    std::vector<Observations::MayHold> whiles = {{first, came, after, std, shown, true}};
    if (came < shown) whiles.push_back({came, shown, before, std, shown, false});
    found.emplace_back(change * gap, std::move(whiles));
    out.open_changes.push_back({first, shown});
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (usual > long_row_s && !rows_at_changes && found.size() <= most_uncertain_changes) out.told_row_s = usual;
  if (found.size() > most_uncertain_changes) found.resize(most_uncertain_changes);
  for (auto& [size, whiles] : found) std::move(whiles.begin(), whiles.end(), std::back_inserter(out.may_hold));
  return result;
}

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
    out.start_spread_K = 1.0;
    return;
  }
  // The median: one sensor that is off should not move the start of all others.
  out.start_C = core::quantile(first, 0.5);
  std::vector<double> distance;
  for (const double value : first) distance.push_back(std::abs(value - out.start_C));
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
  const std::vector<Channel> inputs = compensation::channels_of(channels);
  const std::vector<bool> average = averageable(inputs);
  const std::vector<Watched> watched = watched_channels(rows, inputs);
  make_steps(input_times(time, rows, watched, average, options.changes, measurement.rows_at_changes, out), rows,
             std::min(options.longest_step_s, out.interval / 2.0), average, switched_channels(rows, watched, average),
             out);
  if (const int hour = channels.index(mesh::time_of_day); hour >= 0) set_hours(time, rows.col(hour), hour, out);
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
