// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/grey_box.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "diagnosis/covariance.h"
#include "diagnosis/evidence.h"
#include "diagnosis/readings.h"
#include "diagnosis/statistics.h"

namespace thermotwin::diagnosis {

using compensation::ChannelKind;
using compensation::MeasuredChannel;
using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr double grid_s[] = {0, 600, 1800, 3600, 7200, 14400, 28800, 57600};
constexpr double wander_levels[] = {0.02, 0.05, 0.1, 0.2, 0.4}, wander_times[] = {3600, 10800, 43200};
constexpr double gain_width = 2.0;  ///< prior of a gain: this times target's spread over input's spread
constexpr int sweeps = 3;
constexpr double least_weight = 1e-9;  ///< of a time constant, against the best one

double spread(const VectorXd& values) {
  std::vector<double> good;
  for (const double v : values)
    if (std::isfinite(v)) good.push_back(v);
  if (good.size() < 2) return 0.0;
  const double mean = Eigen::Map<VectorXd>(good.data(), static_cast<Index>(good.size())).mean();
  double sum = 0.0;
  for (const double v : good) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(good.size()));
}

/// Means over the intervals; NaN where there is no value.
VectorXd interval_means(const VectorXd& time, const VectorXd& values, double start, double interval, Index count) {
  VectorXd sum = VectorXd::Zero(count), n = VectorXd::Zero(count);
  for (Index i = 0; i < time.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const Index at = std::min(static_cast<Index>((time[i] - start) / interval), count - 1);
    sum[at] += values[i];
    n[at] += 1.0;
  }
  VectorXd means(count);
  for (Index i = 0; i < count; ++i) means[i] = n[i] > 0 ? sum[i] / n[i] : missing;
  return means;
}

void fill_gaps(VectorXd& values) {
  Index first = 0;
  while (first < values.size() && !std::isfinite(values[first])) ++first;
  if (first == values.size()) return;
  for (Index i = 0; i < first; ++i) values[i] = values[first];
  for (Index i = first + 1; i < values.size(); ++i)
    if (!std::isfinite(values[i])) values[i] = values[i - 1];
}

}  // namespace

DataRecord data_record(const compensation::Measurement& measurement, double interval_s) {
  const std::string place = measurement.folder.string();
  const VectorXd time = measurement.time();
  if (time.size() < 2) throw InputError(place, fmt::format("{} rows of data", time.size()), "a record of several intervals of time");
  DataRecord record;
  record.interval = interval_s;
  const double start = time[0];
  const auto count = static_cast<Index>(std::ceil((time[time.size() - 1] - start) / interval_s));
  if (count < 36)
    throw InputError(place, fmt::format("a record of {:.0f} s", time[time.size() - 1] - start),
                     fmt::format("at least 36 intervals of {:.0f} s: a part to fit, one to compare and one to judge", interval_s));
  record.time = VectorXd::LinSpaced(count, start + 0.5 * interval_s, start + (static_cast<double>(count) - 0.5) * interval_s);
  std::vector<VectorXd> inputs, targets;
  for (const MeasuredChannel& channel : measurement.channels) {
    VectorXd means = interval_means(time, measurement.values(channel), start, interval_s, count);
    const bool empty = !means.array().isFinite().any();
    if (channel.kind == ChannelKind::displacement) {
      if (empty) continue;
      targets.push_back(std::move(means));
      record.channels.push_back(channel);
    } else if (!empty && channel.kind != ChannelKind::position) {
      fill_gaps(means);
      if (!(spread(means) > 1e-9)) continue;  // a constant input explains nothing beside the constant
      inputs.push_back(std::move(means));
      record.input_names.push_back(channel.id);
      record.input_units.push_back(channel.unit);
    }
  }
  if (targets.empty()) throw InputError(place, "no channel of kind displacement with data", "one or more displacements to explain");
  if (inputs.empty()) throw InputError(place, "no temperature or other input that changes", "one or more channels that displacements may follow");
  record.inputs.resize(count, static_cast<Index>(inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i) record.inputs.col(static_cast<Index>(i)) = inputs[i];
  record.targets.resize(count, static_cast<Index>(targets.size()));
  for (std::size_t i = 0; i < targets.size(); ++i) record.targets.col(static_cast<Index>(i)) = targets[i];
  return record;
}

MatrixXd GreyBox::columns(const DataRecord& record) const {
  MatrixXd columns(record.time.size(), record.inputs.cols() + 1);
  for (Index i = 0; i < record.inputs.cols(); ++i) {
    // Deviations from the start: an element begins in balance.
    const VectorXd input = record.inputs.col(i).array() - record.inputs(0, i);
    columns.col(i) = lagged(record.time, input, time_constants[i]);
  }
  columns.col(record.inputs.cols()).setOnes();
  return columns;
}

namespace {

/// The rows of a fit, and a box's evidence on them.
class Fit {
 public:
  Fit(const DataRecord& record, Index target, const std::vector<Index>& rows) : record_(record) {
    for (const Index row : rows)
      if (std::isfinite(record.targets(row, target))) good_.push_back(row);
    value_ = record.targets(good_, target);
    time_ = record.time(good_);
    size = std::max(spread(value_), 1e-6);
    const double span = time_.size() > 0 ? time_[time_.size() - 1] - time_[0] + record.interval : 0.0;
    for (const double tau : grid_s)
      if (tau <= span) time_constants.push_back(tau);
    const Index inputs = record.inputs.cols();
    prior_.resize(inputs + 1);
    for (Index i = 0; i < inputs; ++i) prior_[i] = gain_width * size / std::max(spread(record.inputs(good_, i)), 1e-9);
    prior_[inputs] = 3.0 * size;
  }

  /// With its gains and its evidence.
  GreyBox inferred(GreyBox box) const {
    const auto n = static_cast<Index>(good_.size());
    const Whitener white({{time_, VectorXd::Constant(n, box.noise_std * box.noise_std), VectorXd::Zero(n), {{box.wander_std, box.wander_time}}}});
    const LinearEvidence evidence(white.whiten(MatrixXd(box.columns(record_)(good_, Eigen::all))), white.whiten(value_), prior_);
    box.log_evidence = evidence.log_evidence() - 0.5 * white.log_determinant();
    box.gains = evidence.mean();
    box.covariance = evidence.covariance();
    return box;
  }

  double size = 0;                      ///< spread of the target
  std::vector<double> time_constants;   ///< of the grid, none longer than the rows last

 private:
  const DataRecord& record_;
  std::vector<Index> good_;
  VectorXd value_, time_, prior_;
};

}  // namespace

GreyBox fit_grey_box(const DataRecord& record, Index target, const std::vector<Index>& rows, const VectorXd& start) {
  const Fit fit(record, target, rows);
  const Index inputs = record.inputs.cols();
  GreyBox best;
  best.time_constants = start.size() > 0 ? start : VectorXd::Constant(inputs, 1800.0);
  best.wander_std = 0.1 * fit.size;
  best.wander_time = 10800.0;
  best.noise_std = std::max(record.channels[static_cast<std::size_t>(target)].uncertainty, 1e-3 * fit.size);
  best.log_evidence = -std::numeric_limits<double>::infinity();
  const auto try_box = [&](const GreyBox& tried) {
    GreyBox box = fit.inferred(tried);
    if (box.log_evidence > best.log_evidence) best = std::move(box);
  };
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const double before = best.log_evidence;
    for (const double level : wander_levels)
      for (const double wander_time : wander_times) {
        GreyBox box = best;
        box.wander_std = level * fit.size;
        box.wander_time = wander_time;
        try_box(box);
      }
    for (Index i = 0; i < inputs; ++i)
      for (const double tau : fit.time_constants) {
        GreyBox box = best;
        box.time_constants[i] = tau;
        try_box(box);
      }
    if (best.log_evidence - before < 1e-3) break;
  }
  return best;
}

TimeConstant time_constant_of(const DataRecord& record, Index target, const std::vector<Index>& rows, const GreyBox& box, Index input) {
  const Fit fit(record, target, rows);
  double sum = 0.0, mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < fit.time_constants.size(); ++i) {
    const double tau = fit.time_constants[i], below = i > 0 ? fit.time_constants[i - 1] : tau,
                 above = i + 1 < fit.time_constants.size() ? fit.time_constants[i + 1] : tau;
    GreyBox tried = box;
    tried.time_constants[input] = tau;
    const double weight = std::exp(fit.inferred(tried).log_evidence - box.log_evidence), width = 0.5 * (above - below);
    if (weight < least_weight) continue;
    sum += weight;
    mean += weight * tau;
    square += weight * (tau * tau + width * width / 12.0);  // spread evenly between the neighbours of the grid
  }
  mean /= sum;
  return {mean, std::sqrt(std::max(square / sum - mean * mean, 0.0))};
}

}  // namespace thermotwin::diagnosis
