// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/data_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/missing.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using core::missing;
using compensation::ChannelKind;
using compensation::MeasuredChannel;
using core::InputError;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

struct IntervalMeans {
  VectorXd mean, count;  ///< NaN and 0 where there is no value
};

IntervalMeans interval_means(const VectorXd& time, const VectorXd& values, double start, double interval, Index count) {
  IntervalMeans means{VectorXd::Zero(count), VectorXd::Zero(count)};
  for (Index i = 0; i < time.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const Index at = std::min(static_cast<Index>((time[i] - start) / interval), count - 1);
    means.mean[at] += values[i];
    means.count[at] += 1.0;
  }
  for (Index i = 0; i < count; ++i) means.mean[i] = means.count[i] > 0 ? means.mean[i] / means.count[i] : missing;
  return means;
}

/// @param interpolate  a straight line over a gap; else the last value. Before the first value: that one
void fill_gaps(VectorXd& values, bool interpolate) {
  Index last = -1;
  for (Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    for (Index j = last + 1; j < i; ++j) {
      const double done = j - last, share = done / (i - last);
      values[j] = last < 0 ? values[i] : interpolate ? values[last] + share * (values[i] - values[last]) : values[last];
    }
    last = i;
  }
  for (Index j = last + 1; last >= 0 && j < values.size(); ++j) values[j] = values[last];
}

}  // namespace

DataRecord data_record(const compensation::Measurement& measurement, double interval_s) {
  const std::string place = measurement.folder.string();
  const VectorXd time = measurement.time();
  if (time.size() < 2)
    throw InputError(place, fmt::format("{} rows of data", time.size()), "a record of several intervals of time");
  DataRecord record;
  record.interval = interval_s;
  const double start = time[0];
  const auto count = static_cast<Index>(std::ceil((time[time.size() - 1] - start) / interval_s));
  if (count < 36) {
    throw InputError(
        place, fmt::format("a record of {:.0f} s", time[time.size() - 1] - start),
        fmt::format("at least 36 intervals of {:.0f} s, for three parts: fitting, comparison, judgement", interval_s));
  }
  record.time = VectorXd::LinSpaced(count, start + 0.5 * interval_s, start + (count - 0.5) * interval_s);
  std::vector<VectorXd> inputs, targets, counts;
  for (const MeasuredChannel& channel : measurement.channels) {
    auto [means, readings] = interval_means(time, measurement.values(channel), start, interval_s, count);
    const bool empty = !means.array().isFinite().any();
    if (channel.kind == ChannelKind::displacement) {
      if (empty) continue;
      targets.push_back(std::move(means));
      counts.push_back(std::move(readings));
      record.channels.push_back(channel);
    } else if (!empty && channel.kind != ChannelKind::position) {
      fill_gaps(means, channel.kind == ChannelKind::temperature);
      if (!(spread_of(means) > 1e-9)) continue;  // a constant input explains nothing beside the constant
      inputs.push_back(std::move(means));
      record.input_names.push_back(channel.id);
      record.input_units.push_back(channel.unit);
    }
  }
  if (targets.empty())
    throw InputError(place, "no channel of kind displacement with data", "one or more channels of kind displacement");
  if (inputs.empty()) {
    throw InputError(place, "no temperature or other input that changes",
                     "one or more temperatures, speeds, powers or states that vary");
  }
  record.inputs.resize(count, std::ssize(inputs));
  for (std::size_t i = 0; i < inputs.size(); ++i) record.inputs.col(i) = inputs[i];
  record.targets.resize(count, std::ssize(targets));
  record.counts.resize(count, record.targets.cols());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    record.targets.col(i) = targets[i];
    record.counts.col(i) = counts[i];
  }
  return record;
}

}  // namespace thermotwin::diagnosis
