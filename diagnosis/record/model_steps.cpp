// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/model_steps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "compensation/measurement/channel.h"
#include "compensation/measurement/measurement_check.h"
#include "compensation/measurement/stretch.h"
#include "core/interpolation.h"
#include "diagnosis/record/pauses.h"

namespace thermotwin::diagnosis {

using compensation::Channel;
using compensation::Quantity;
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
  const auto same = [](double a, double b) { return std::abs(a - b) < 1e-6; };
  const auto may_change = [&](double at) {
    return std::any_of(out.may_hold.begin(), out.may_hold.end(),
                       [&](const auto& may) { return same(may.earlier ? may.to : may.from, at); }) ||
           std::any_of(out.pauses.begin(), out.pauses.end(), [&](const auto& pause) { return same(pause.shown, at); });
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
/// a pause longer than an interval and a few rows the row before it holds as it says, or for a part of it, or anything
/// else ran: more rows may be lost than a few.
Eigen::VectorXd input_times(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows,
                            const std::vector<Watched>& watched, const std::vector<bool>& average,
                            const std::map<double, double>& changes, bool rows_at_changes, Observations& out) {
  const Index n = time.size();
  const double usual = compensation::usual_interval(time);
  Eigen::VectorXd result = time;
  std::vector<std::pair<double, std::vector<Observations::MayHold>>> found;
  std::vector<Index> switchable;  // what wanders is not switched; where an axis swings changes with its feed
  for (Index c = 0; c < rows.cols(); ++c) {
    if (!average[c] || std::any_of(watched.begin(), watched.end(), [c](const Watched& w) { return w.channel == c; }))
      switchable.push_back(c);
  }
  for (Index i = 0; i + 1 < n; ++i) {
    const double shown = time[i + 1], gap = shown - time[i];
    const bool of_a_row = gap <= gap_intervals * usual;
    const bool of_a_pause = gap > std::max(out.interval, pause_intervals * usual);
    if (of_a_pause) out.pauses.push_back({time[i], shown});
    if (i + 2 == n) break;  // what the last row says holds for nothing
    if (rows_at_changes && (of_a_row || of_a_pause)) continue;
    if (of_a_row && (usual <= long_row_s || gap <= short_gap * long_row_s)) continue;
    const double change = change_between(rows.row(i), rows.row(i + 1), watched);
    if (change < changed_share) continue;
    const Eigen::VectorXd after = rows.row(i + 1).transpose(), before = rows.row(i).transpose();
    const double first = of_a_row ? time[i] : shown - (gap - usual), nearest = first + least_part * (shown - first);
    const auto known = changes.find(shown);
    const double came = known != changes.end()   ? std::clamp(known->second, nearest, shown)
                        : of_a_row || of_a_pause ? shown
                                                 : 0.5 * (first + shown);
    result[i + 1] = came;
    // Anywhere alike: the mean square of how far it is off, shared by two tangents of opposite sign.
    const double a = came - first, b = shown - came,
                 std = std::sqrt((a * a * a + b * b * b) / (3.0 * (a + b) * (a * a + b * b)));
    std::vector<Observations::MayHold> whiles = {{first, came, after, switchable, std, shown, true}};
    if (came < shown) whiles.push_back({came, shown, before, switchable, std, shown, false});
    found.emplace_back(change * gap, std::move(whiles));
    out.open_changes.push_back({first, shown});
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  if (usual > long_row_s && !rows_at_changes && found.size() <= most_uncertain_changes) out.told_row_s = usual;
  if (found.size() > most_uncertain_changes) found.resize(most_uncertain_changes);
  for (auto& [size, whiles] : found) std::move(whiles.begin(), whiles.end(), std::back_inserter(out.may_hold));
  return result;
}

}  // namespace

void set_model_steps(const compensation::Measurement& measurement, const solver::Channels& channels,
                     const Eigen::MatrixXd& rows, const ObserveOptions& options, Observations& out) {
  const Eigen::VectorXd time = measurement.time();
  const std::vector<Channel> inputs = compensation::channels_of(channels);
  const std::vector<bool> average = averageable(inputs);
  const std::vector<Watched> watched = watched_channels(rows, inputs);
  make_steps(input_times(time, rows, watched, average, options.changes, measurement.rows_at_changes, out), rows,
             std::min(options.longest_step_s, out.interval / 2.0), average, switched_channels(rows, watched, average),
             out);
  std::vector<Watched> recorded = watched;  // an input without a column keeps its value all the time
  std::erase_if(recorded, [&](const Watched& w) {
    return std::none_of(measurement.channels.begin(), measurement.channels.end(),
                        [&](const auto& channel) { return channel.input == inputs[w.channel].name; });
  });
  add_unknown_operation(rows, inputs, recorded, !measurement.rows_at_changes, out);
  let_wander(time, rows, inputs, out);
  if (const int hour = channels.index(mesh::time_of_day); hour >= 0) set_hours(time, rows.col(hour), hour, out);
}

}  // namespace thermotwin::diagnosis
