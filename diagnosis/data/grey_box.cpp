// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/grey_box.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/error.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/record/readings.h"
#include "diagnosis/statistics/statistics.h"

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
constexpr double wander_levels[] = {0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4}, wander_times[] = {3600, 10800, 43200};
constexpr double widths[] = {0.02, 0.1, 0.3, 1.0,
                             3.0};  ///< prior of a gain: this times target's spread over input's spread
constexpr double noise_factors[] = {1, 1.2, 1.5, 2, 3,
                                    5, 10,  30};  ///< of the stated uncertainty, as if independent between readings
constexpr double least_noise = 1e-3;              ///< of the target's spread
constexpr int sweeps = 3;

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
      const double share = static_cast<double>(j - last) / (i - last);
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

double spread_of(const VectorXd& values) {
  std::vector<double> good;
  for (const double v : values)
    if (std::isfinite(v)) good.push_back(v);
  if (good.size() < 2) return 0.0;
  const VectorXd finite = Eigen::Map<VectorXd>(good.data(), std::ssize(good));
  return root_mean_square(finite.array() - finite.mean());
}

MatrixXd GreyBox::columns(const DataRecord& record) const {
  const auto elements = std::ssize(time_constants), inputs = record.inputs.cols();
  MatrixXd columns(record.time.size(), inputs * elements + 1);
  for (Index i = 0; i < inputs; ++i) {
    // Deviations from the start: an element begins in balance.
    const VectorXd input = record.inputs.col(i).array() - record.inputs(0, i);
    for (Index k = 0; k < elements; ++k) columns.col(i * elements + k) = lagged(record.time, input, time_constants[k]);
  }
  columns.col(inputs * elements).setOnes();
  return columns;
}

ChannelCovariance GreyBox::left_over(const DataRecord& record, const std::vector<Index>& rows) const {
  const VectorXd noise = noise_std(rows);
  return {record.time(rows), noise.cwiseAbs2(), VectorXd::Zero(noise.size()), {{wander_std, wander_time}}};
}

double GreyBox::step_response(Index input, double seconds) const {
  const auto elements = std::ssize(time_constants);
  double moved = 0.0;
  for (Index k = 0; k < elements; ++k) {
    const double tau = time_constants[k];
    moved += gains[input * elements + k] * (tau > 0.0 ? -std::expm1(-seconds / tau) : 1.0);
  }
  return moved;
}

GreyBox fit_grey_box(const DataRecord& record, Index target, const std::vector<Index>& rows) {
  std::vector<Index> good;
  for (const Index row : rows)
    if (std::isfinite(record.targets(row, target))) good.push_back(row);
  const VectorXd value = record.targets(good, target);
  const Index inputs = record.inputs.cols();
  const double size = std::max(spread_of(value), 1e-6);
  const double span = good.empty() ? 0.0 : record.time[good.back()] - record.time[good.front()] + record.interval;

  GreyBox best;
  for (const double tau : grid_s)
    if (tau <= span) best.time_constants.push_back(tau);
  const auto elements = std::ssize(best.time_constants);
  best.fitted = std::ssize(good);
  best.log_evidence = -std::numeric_limits<double>::infinity();
  const MatrixXd columns = best.columns(record)(good, Eigen::all);
  const VectorXd least =
      (record.channels[target].uncertainty * record.counts.col(target).cwiseMax(1.0).cwiseSqrt().cwiseInverse())
          .cwiseMax(least_noise * size);

  struct Levels {
    VectorXd widths;
    double wander, wander_time, noise;
  };
  Levels levels{VectorXd::Constant(inputs, 0.3), 0.1, 10800.0, 1.0};
  const auto attempt = [&](const Levels& tried) {
    GreyBox box = best;
    box.prior_std = VectorXd::Constant(inputs * elements + 1, 3.0 * size);
    for (Index i = 0; i < inputs; ++i) {
      box.prior_std.segment(i * elements, elements)
          .setConstant(tried.widths[i] * size / std::max(spread_of(record.inputs(good, i)), 1e-9));
    }
    box.wander_std = tried.wander * size;
    box.wander_time = tried.wander_time;
    box.noise_std = tried.noise * least;
    const Whitener white({box.left_over(record, good)});
    const LinearEvidence evidence(white.whiten(columns), white.whiten(value), box.prior_std);
    box.log_evidence = evidence.log_evidence() - 0.5 * white.log_determinant();
    if (!(box.log_evidence > best.log_evidence)) return;
    box.chi_square = evidence.chi_square();
    box.gains = evidence.mean();
    box.covariance = evidence.covariance();
    best = std::move(box);
    levels = tried;
  };
  attempt(levels);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const double before = best.log_evidence;
    for (const double wander : wander_levels)
      for (const double time : wander_times) attempt({levels.widths, wander, time, levels.noise});
    for (const double noise : noise_factors) attempt({levels.widths, levels.wander, levels.wander_time, noise});
    for (Index i = 0; i < inputs; ++i) {
      for (const double width : widths) {
        Levels tried = levels;
        tried.widths[i] = width;
        attempt(tried);
      }
    }
    if (best.log_evidence - before < 1e-3) break;
  }
  return best;
}

}  // namespace thermotwin::diagnosis
