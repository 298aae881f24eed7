// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/channel_finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/text.h"
#include "core/units.h"
#include "diagnosis/report/words.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using core::units::hour;
constexpr double sure = 0.9, discrepant = 0.01;  ///< probability of a cause; p value of a residual
constexpr double shares = 0.05;                  ///< probability from which a cause stays in an ambiguous set
/// Expected spread over the channel's own spread, above which a discrepancy as large as the signal would pass.
constexpr double too_wide = 0.5;
constexpr double still_below = 1e-3;  ///< of an input's later range: it stood still in the first part
/// Probability of none, below which a record without a discrepancy is not called clean.
constexpr double doubtful = 0.1;
/// Times its uncertainty, by which a channel varies that has something to be explained.
constexpr double moves = 2.0;

/// Time by which a residual forgets itself, from its correlation one interval apart; s. Infinite where it does not.
double memory_of(const VectorXd& residual, const std::vector<Index>& rows, double interval) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i] != rows[i - 1] + 1) continue;
    const double a = residual[rows[i]], b = residual[rows[i - 1]];
    product += a * b;
    square += 0.5 * (a * a + b * b);
  }
  const double correlation = square > 0.0 ? product / square : 0.0;
  if (correlation >= 1.0) return std::numeric_limits<double>::infinity();
  return correlation > 0.0 ? -interval / std::log(correlation) : 0.0;
}

double correlation(const VectorXd& a, const VectorXd& b) {
  const VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  const double size = x.norm() * y.norm();
  return size > 0.0 ? x.dot(y) / size : 0.0;
}

/// A record that cannot tell leaves every probability at its prior: its noise was learnt where too little happened.
void keep_prior(WeighedChannel& weighed) {
  weighed.none = prior_none;
  weighed.unknown = prior_unknown;
  for (Extension& extension : weighed.extensions) extension.probability = prior_cause / std::ssize(weighed.extensions);
}

std::vector<OnLastPart> on_last_part(const DataRecord& record, const ChannelFinding& finding) {
  const auto block = static_cast<Index>(std::lround(2.0 * hour / record.interval));
  const VectorXd before = finding.weighed.before(finding.last);
  std::vector<OnLastPart> all;
  for (const Extension& extension : finding.weighed.extensions) {
    const VectorXd after = (record.targets.col(finding.target) - extension.predicted)(finding.last);
    const double rms = root_mean_square(after);
    all.push_back({rms, reduction_percent(root_mean_square(before), rms),
                   reduction_interval(before.cwiseAbs2(), after.cwiseAbs2(), block)});
  }
  return all;
}

/// In words, with the time at which a drift begins.
std::string described(const Extension& extension) {
  if (extension.kind != Kind::probe_drift) return name_of(extension.kind);
  return fmt::format("{} of {}{} +- {} {} from hour {:.0f} on", name_of(extension.kind),
                     extension.value < 0.0 ? "" : "+", core::plain_number(extension.value, 3),
                     core::plain_number(extension.std, 2), extension.unit, extension.begins / hour);
}

std::string residual_in_numbers(const DataRecord& record, const ChannelFinding& finding) {
  const std::vector<Index>& later = finding.later;
  const VectorXd residual = finding.weighed.before(later);
  double strongest = 0.0;
  std::string follows;
  for (Index i = 0; i < record.inputs.cols(); ++i) {
    if (const double r = correlation(record.inputs.col(i)(later), residual); std::abs(r) > std::abs(strongest))
      strongest = r, follows = record.input_names[i];
  }
  const VectorXd since = record.time(later).array() - record.time[later.front()];
  const double memory = memory_of(finding.weighed.before, later, record.interval), length = since[since.size() - 1];
  double slope = 0.0;
  if (since.size() > 2) {
    const VectorXd time = since.array() - since.mean();
    slope = time.dot((residual.array() - residual.mean()).matrix()) / time.squaredNorm() * hour;
  }
  return fmt::format(
      "{}: RMS after the first part {:.2f} against {:.2f} expected, mean {:+.2f}, {:+.3f} per hour, {}, correlation "
      "{:+.2f} with {}.",
      finding.channel, finding.weighed.seen, finding.weighed.expected, residual.mean(), slope,
      memory < length ? fmt::format("correlation time {:.1f} h", memory / hour)
                      : fmt::format("correlation time above {:.1f} h", length / hour),
      strongest, follows);
}

/// The input whose gains widen the prediction most.
Index least_known_input(const DataRecord& record, const LagModel& model, const MatrixXd& columns) {
  const Index elements = std::ssize(model.time_constants);
  Index least_known = 0;
  double most = -1.0;
  for (Index i = 0; i < record.inputs.cols(); ++i) {
    const MatrixXd own = columns.middleCols(i * elements, elements);
    const MatrixXd told = own * model.covariance.block(i * elements, i * elements, elements, elements);
    if (const double share = told.cwiseProduct(own).sum(); share > most) most = share, least_known = i;
  }
  return least_known;
}

}  // namespace

bool ChannelFinding::names() const {
  return discrepancy && last_part[best].gain.low > 0.0 && leading().probability >= sure;
}

bool ChannelFinding::open() const { return (untold || doubt) && !names(); }

bool ChannelFinding::refused() const {
  return discrepancy && leading().probability >= sure && !(last_part[best].gain.low > 0.0);
}

// All hours after the first part refuse none where there is a discrepancy: what the middle part alone gives it is
// unknown.
double ChannelFinding::none() const { return clean() || open() ? weighed.none : 0.0; }

double ChannelFinding::unknown() const { return weighed.unknown + weighed.none - none(); }

VectorXd ChannelFinding::after(const DataRecord& record) const {
  return names() ? record.targets.col(target) - leading().predicted : weighed.before;
}

ChannelFinding find_in_channel(const DataRecord& record, const RecordSegments& segments, Index target,
                               const std::vector<double>& signals) {
  const auto varies = [&](Index t) { return signals[t] > moves * record.channels[t].uncertainty; };
  bool any_moves = false;
  for (Index t = 0; t < record.targets.cols(); ++t) any_moves = any_moves || varies(t);
  ChannelFinding finding;
  finding.target = target;
  finding.channel = record.channels[target].id;
  finding.unit = record.channels[target].unit;
  finding.weighed = weigh_channel(record, target, segments);
  WeighedChannel& weighed = finding.weighed;
  finding.last = finite_rows(record.targets.col(target), segments.last);
  finding.later = finite_rows(record.targets.col(target), joined(segments.middle, segments.last));
  finding.signal = signals[target];
  finding.rms_before = root_mean_square(weighed.before(finding.last));
  finding.discrepancy = weighed.p_value < discrepant;
  finding.untold = weighed.expected > too_wide * finding.signal && weighed.seen <= 2.0 * weighed.expected &&
                   (varies(target) || !any_moves);
  finding.doubt = !finding.discrepancy && weighed.none < doubtful;
  for (std::size_t i = 0; i < weighed.extensions.size(); ++i)
    if (weighed.extensions[i].probability > finding.leading().probability) finding.best = i;
  finding.last_part = on_last_part(record, finding);
  for (std::size_t i = 0; i < weighed.extensions.size(); ++i) {
    if (finding.last_part[i].gain.low > 0.0 && (i == finding.best || weighed.extensions[i].probability >= shares))
      finding.holding.push_back(i);
  }
  if (finding.untold && finding.open()) keep_prior(weighed);
  return finding;
}

RankedCause cause_of(const ChannelFinding& finding, std::size_t index) {
  const Extension& extension = finding.weighed.extensions[index];
  RankedCause cause;
  cause.parameter.kind = extension.kind;
  cause.parameter.where = finding.channel;
  cause.parameter.name = extension.name;
  cause.parameter.unit = extension.unit;
  cause.parameter.ratio = false;
  cause.parameter.nominal = 0.0;
  cause.probability = extension.probability;
  cause.log_evidence = extension.log_evidence;
  cause.value = extension.value;
  cause.std = extension.std;
  cause.heldout_explained_percent = finding.last_part[index].explained_percent;
  return cause;
}

RankedCause no_cause(Kind kind, const std::string& channel, double probability, double log_evidence) {
  RankedCause row;
  row.parameter.name.clear();
  row.parameter.unit.clear();
  row.parameter.kind = kind;
  row.parameter.where = channel;
  row.probability = probability;
  row.log_evidence = log_evidence;
  return row;
}

std::vector<RankedCause> ranking_of(const ChannelFinding& finding) {
  std::vector<RankedCause> rows;
  for (std::size_t i = 0; i < finding.weighed.extensions.size(); ++i) rows.push_back(cause_of(finding, i));
  rows.push_back(no_cause(Kind::none, finding.channel, finding.none()));
  rows.push_back(no_cause(Kind::unknown, finding.channel, finding.unknown(), finding.weighed.unknown_log_evidence));
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  return rows;
}

std::vector<std::string> notes_of(const DataRecord& record, const ChannelFinding& finding) {
  const OnLastPart& led = finding.last_part[finding.best];
  return {
      fmt::format("{}: {} (probability {:.2f} before the last part) changes the last part's RMS from {:.2f} to {:.2f} "
                  "({} %, 95 % interval {} to {}): {}.",
                  finding.channel, described(finding.leading()), finding.leading().probability, finding.rms_before,
                  led.rms, percent_text(led.explained_percent), percent_text(led.gain.low), percent_text(led.gain.high),
                  led.gain.low > 0.0 ? "the improvement is significant" : "the improvement is not significant"),
      residual_in_numbers(record, finding)};
}

NextMeasurement needed(const DataRecord& record, const RecordSegments& segments, const ChannelFinding& finding) {
  const WeighedChannel& weighed = finding.weighed;
  const std::vector<Index> later = joined(segments.middle, segments.last);
  const MatrixXd columns = weighed.model.columns(record)(later, Eigen::all), told = columns * weighed.model.covariance;
  const double by_gains = std::sqrt(told.cwiseProduct(columns).rowwise().sum().mean());
  NextMeasurement next;
  next.channel = finding.channel;
  const std::string goal = fmt::format(
      "the expected standard deviation has to fall from {:.3g} um below {:.3g} um, half of the variation of {}",
      weighed.expected, too_wide * finding.signal, finding.channel);
  if (by_gains < std::hypot(weighed.model.wander_std, root_mean_square(weighed.model.noise_std(later)))) {
    next.load = "the same operation with one more temperature sensor on the path of its heat";
    next.why = fmt::format("no recorded input explains {:.3g} um of it in the fitted part; {}",
                           weighed.model.wander_std, goal);
    return next;
  }
  const Index input = least_known_input(record, weighed.model, columns),
              elements = std::ssize(weighed.model.time_constants);
  const VectorXd all = record.inputs.col(input), first = all(segments.first);
  const double hours = (segments.first_end - record.time[0]) / hour;
  if (first.maxCoeff() - first.minCoeff() < still_below * (all.maxCoeff() - all.minCoeff())) {
    next.load = fmt::format("a record in whose first part {} varies over {:.4g} to {:.4g} {} as well",
                            record.input_names[input], all.minCoeff(), all.maxCoeff(), record.input_units[input]);
    next.why = fmt::format("{} was constant in the first {:.0f} h, so its effect on {} is unknown",
                           record.input_names[input], hours, finding.channel);
    return next;
  }
  next.load = fmt::format(
      "a longer operation in which {} varies over {:.4g} to {:.4g} {} independently of the other inputs while the "
      "model is fitted (here {:.4g} to {:.4g} in the first {:.0f} h)",
      record.input_names[input], all.minCoeff(), all.maxCoeff(), record.input_units[input], first.minCoeff(),
      first.maxCoeff(), hours);
  const auto own = weighed.model.covariance.block(input * elements, input * elements, elements, elements);
  next.why =
      fmt::format("its steady-state gain is uncertain, {} +- {} um per {}; {}",
                  core::plain_number(weighed.model.step_response(input, std::numeric_limits<double>::infinity()), 3),
                  core::plain_number(std::sqrt(std::max(own.sum(), 0.0)), 2), record.input_units[input], goal);
  return next;
}

}  // namespace thermotwin::diagnosis
