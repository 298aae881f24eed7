// SPDX-License-Identifier: GPL-3.0-or-later
// What is wrong with a grey box on the days after the one it was fitted on, what may explain it, and
// whether that holds on the last day.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/text.h"
#include "diagnosis/covariance.h"
#include "diagnosis/evidence.h"
#include "diagnosis/grey_box.h"
#include "diagnosis/statistics.h"
#include "diagnosis/words.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double day = 86400.0, hour = 3600.0;
constexpr double sure = 0.9, discrepant = 0.01;  ///< probability of a cause; p value of a residual
constexpr double too_wide = 0.5;  ///< expected spread over a channel's own, above which a discrepancy as large as the signal would pass
constexpr double shares = 0.05;   ///< probability of a cause that stays in an ambiguous set
constexpr double moves = 2.0;     ///< times its uncertainty, by which a channel varies that has something to be explained
constexpr double daily_days = 3.0;  ///< length of a record that tells a daily swing from a drift
constexpr double prior_none = 0.5, prior_cause = 0.45, prior_unknown = 0.05;

struct Days {
  std::vector<Index> first, middle, last;
  double first_end = 0, last_start = 0;  ///< s
};

Days divide(const DataRecord& record) {
  const double start = record.time[0] - 0.5 * record.interval, length = record.time[record.time.size() - 1] - record.time[0];
  Days parts;
  const double part = length >= 2.25 * day ? day : length / 3.0;
  parts.first_end = start + part;
  parts.last_start = start + 2.0 * part;
  for (Index i = 0; i < record.time.size(); ++i)
    (record.time[i] < parts.first_end ? parts.first : record.time[i] < parts.last_start ? parts.middle : parts.last).push_back(i);
  return parts;
}

std::vector<Index> joined(const std::vector<Index>& a, const std::vector<Index>& b) {
  std::vector<Index> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

std::vector<Index> finite_rows(const VectorXd& values, const std::vector<Index>& rows) {
  std::vector<Index> good;
  for (const Index row : rows)
    if (std::isfinite(values[row])) good.push_back(row);
  return good;
}

/// A way to extend the grey box: further columns with priors, or the box fitted on more days.
struct Extension {
  std::string kind, name, unit;
  MatrixXd columns;       ///< (n x k)
  VectorXd prior_std;     ///< (k)
  bool refit = false;
  double log_evidence = 0, value = 0, std = 0;
  VectorXd predicted;     ///< (n)
};

/// Time by which a residual forgets itself, from its correlation one interval apart; s. Infinite where it does not.
double memory_of(const VectorXd& residual, const std::vector<Index>& rows, double interval) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i] != rows[i - 1] + 1) continue;
    product += residual[rows[i]] * residual[rows[i - 1]];
    square += 0.5 * (residual[rows[i]] * residual[rows[i]] + residual[rows[i - 1]] * residual[rows[i - 1]]);
  }
  const double correlation = square > 0.0 ? product / square : 0.0;
  return correlation >= 1.0 ? std::numeric_limits<double>::infinity() : correlation > 0.0 ? -interval / std::log(correlation) : 0.0;
}

double correlation(const VectorXd& a, const VectorXd& b) {
  const VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  const double size = x.norm() * y.norm();
  return size > 0.0 ? x.dot(y) / size : 0.0;
}

struct Judged {
  GreyBox box;
  VectorXd before, after, expected_std;  ///< (n) residuals, and what the first day makes one expect
  double expected = 0, seen = 0;         ///< RMS after the first part: of expected_std, of the residual
  double p_value = 1;                    ///< of the later days' residual under the box of the first day
  double probability_none = 1, probability_unknown = 0;
  std::vector<Extension> extensions;
  std::vector<double> probability;       ///< of the extensions
};

/// A record that cannot tell leaves every probability at its prior: its noise was learnt where too little happened.
void keep_prior(Judged& judged) {
  judged.probability_none = prior_none;
  judged.probability_unknown = prior_unknown;
  for (double& p : judged.probability) p = prior_cause / static_cast<double>(judged.extensions.size());
}

/// Standard deviation of what was measured.
double spread_of(const VectorXd& values) {
  std::vector<double> good;
  for (const double v : values)
    if (std::isfinite(v)) good.push_back(v);
  const VectorXd finite = Eigen::Map<const VectorXd>(good.data(), static_cast<Index>(good.size()));
  return finite.size() > 1 ? root_mean_square(finite.array() - finite.mean()) : 0.0;
}

/// The first part leaves so much open that a discrepancy of the signal's own size would pass, and none larger shows.
bool cannot_tell(const Judged& judged, double signal) { return judged.expected > too_wide * signal && judged.seen <= 2.0 * judged.expected; }

/// Log evidence of rows under the box's own process; columns added to its gains, whose posterior is
/// that of the first day.
LinearEvidence evidence_of(const DataRecord& record, const GreyBox& box, const VectorXd& target, const std::vector<Index>& rows,
                           const MatrixXd& added, const VectorXd& added_std, double wander, double& log_determinant) {
  const auto n = static_cast<Index>(rows.size());
  const MatrixXd all = box.columns(record)(rows, Eigen::all);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(box.covariance);
  const MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  MatrixXd columns(n, root.cols() + added.cols());
  columns << all * root, MatrixXd(added(rows, Eigen::all));
  VectorXd prior(columns.cols());
  prior << VectorXd::Ones(root.cols()), added_std;
  const Whitener white({{record.time(rows), VectorXd::Constant(n, box.noise_std * box.noise_std), VectorXd::Zero(n),
                         {{wander * box.wander_std, box.wander_time}}}});
  log_determinant = white.log_determinant();
  return LinearEvidence(white.whiten(columns), white.whiten(target(rows) - all * box.gains), prior);
}

std::vector<Extension> candidates(const DataRecord& record, double size) {
  const Index n = record.time.size();
  const VectorXd since = record.time.array() - record.time[0];
  std::vector<Extension> all;
  Extension drift{"probe_drift", "drift", "um/h", since / hour, VectorXd::Constant(1, size / 24.0), false, 0, 0, 0, {}};
  all.push_back(drift);
  if (static_cast<double>(n) * record.interval >= daily_days * day) {
    MatrixXd daily(n, 4);
    for (Index i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * record.time[i] / day;
      daily.row(i) << std::sin(angle), std::cos(angle), std::sin(2.0 * angle), std::cos(2.0 * angle);
    }
    all.push_back({"unmeasured_temperature", "daily_amplitude", "um", daily, (VectorXd(4) << 0.5, 0.5, 0.25, 0.25).finished() * size, false, 0, 0, 0, {}});
  }
  all.push_back({"time_constant", "slowest", "s", MatrixXd(n, 0), VectorXd(0), true, 0, 0, 0, {}});
  return all;
}

Judged judge_channel(const DataRecord& record, Index target, const Days& parts) {
  Judged judged;
  const VectorXd value = record.targets.col(target);
  const std::vector<Index> first = finite_rows(value, parts.first), middle = finite_rows(value, parts.middle),
                           last = finite_rows(value, parts.last), later = joined(middle, last);
  judged.box = fit_grey_box(record, target, first);
  const GreyBox& box = judged.box;
  const MatrixXd columns = box.columns(record);
  const VectorXd predicted = columns * box.gains;
  judged.before = value - predicted;
  judged.expected_std = ((columns * box.covariance).cwiseProduct(columns).rowwise().sum().array() +
                         box.wander_std * box.wander_std + box.noise_std * box.noise_std).sqrt();
  judged.after = judged.before;
  double determinant = 0.0;
  const MatrixXd nothing(record.time.size(), 0);
  const VectorXd none_std(0);
  const LinearEvidence all_later = evidence_of(record, box, value, later, nothing, none_std, 1.0, determinant);
  judged.expected = root_mean_square(judged.expected_std(later));
  judged.seen = root_mean_square(judged.before(later));
  judged.p_value = chi_square_tail(all_later.chi_square(), static_cast<double>(later.size()));

  // Hypotheses compete on the middle part, given the first; the last one is never fitted.
  const LinearEvidence none = evidence_of(record, box, value, middle, nothing, none_std, 1.0, determinant);
  const double log_none = none.log_evidence() - 0.5 * determinant;
  const double size = std::max({root_mean_square(judged.before(middle)), root_mean_square(value(first).array() - value(first).mean()), 1e-6});
  judged.extensions = candidates(record, size);
  std::vector<double> logs = {std::log(prior_none) + log_none};
  for (Extension& extension : judged.extensions) {
    if (extension.refit) {
      // The same elements with other time constants and gains, on both parts.
      const std::vector<Index> longer = joined(first, middle);
      const GreyBox both = fit_grey_box(record, target, longer, box.time_constants);
      // Time constants are taken at their best: each costs half a logarithm of the values.
      extension.log_evidence = both.log_evidence - box.log_evidence -
                               0.5 * static_cast<double>(record.inputs.cols()) * std::log(static_cast<double>(middle.size()));
      extension.predicted = both.columns(record) * both.gains;
      Index slowest = 0;
      both.time_constants.maxCoeff(&slowest);
      const TimeConstant tau = time_constant_of(record, target, longer, both, slowest);
      extension.value = tau.value;
      extension.std = tau.std;
    } else {
      const LinearEvidence wide = evidence_of(record, box, value, middle, extension.columns, extension.prior_std, 1.0, determinant);
      extension.log_evidence = wide.log_evidence() - 0.5 * determinant;
      const Index k = extension.columns.cols();
      const VectorXd gains = wide.mean().tail(k);
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(box.covariance);
      const VectorXd moved = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * wide.mean().head(box.gains.size());
      extension.predicted = predicted + columns * moved + extension.columns * gains;
      extension.value = k == 1 ? gains[0] : gains.head(2).norm();
      extension.std = std::sqrt(wide.covariance().bottomRightCorner(k, k).diagonal().maxCoeff());
    }
    logs.push_back(std::log(prior_cause / static_cast<double>(judged.extensions.size())) + extension.log_evidence);
  }
  double unknown = -std::numeric_limits<double>::infinity();
  for (const double wander : {2.0, 4.0, 8.0}) {
    const LinearEvidence wide = evidence_of(record, box, value, middle, nothing, none_std, wander, determinant);
    unknown = std::max(unknown, wide.log_evidence() - 0.5 * determinant - std::log(3.0));
  }
  logs.push_back(std::log(prior_unknown) + unknown);
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (double& log : logs) sum += log = std::exp(log - top);
  judged.probability_none = logs.front() / sum;
  judged.probability_unknown = logs.back() / sum;
  for (std::size_t i = 0; i < judged.extensions.size(); ++i) {
    judged.probability.push_back(logs[i + 1] / sum);
    judged.extensions[i].log_evidence -= log_none;
  }
  return judged;
}

/// Sums of squares per interval of the last part.
Interval last_interval(const VectorXd& before, const VectorXd& after, const std::vector<Index>& rows, double interval) {
  return reduction_interval(before(rows).cwiseAbs2(), after(rows).cwiseAbs2(), static_cast<Index>(std::lround(2.0 * hour / interval)));
}

/// @param explained_percent  of the channel's RMS in the last part
RankedCause ranked(const Extension& extension, const std::string& channel, double probability, double explained_percent) {
  RankedCause cause;
  cause.parameter.kind = extension.kind;
  cause.parameter.where = channel;
  cause.parameter.name = extension.name;
  cause.parameter.unit = extension.unit;
  cause.parameter.ratio = false;
  cause.parameter.nominal = 0.0;
  cause.probability = probability;
  cause.log_evidence = extension.log_evidence;
  cause.value = extension.value;
  cause.std = extension.std;
  cause.heldout_explained_percent = explained_percent;
  return cause;
}

/// What an extension makes of the last part.
struct OnLastPart {
  double rms = 0, explained_percent = 0;  ///< of the RMS there
  Interval gain;                          ///< percent
};

std::vector<OnLastPart> on_last_part(const DataRecord& record, Index target, const Judged& judged, const std::vector<Index>& last) {
  std::vector<OnLastPart> all;
  for (const Extension& extension : judged.extensions) {
    const VectorXd after = record.targets.col(target) - extension.predicted;
    const double rms = root_mean_square(after(last));
    all.push_back({rms, reduction_percent(root_mean_square(judged.before(last)), rms), last_interval(judged.before, after, last, record.interval)});
  }
  return all;
}

RankedCause no_cause(const std::string& kind, double probability) {
  RankedCause row;
  row.parameter.name.clear();
  row.parameter.unit.clear();
  row.parameter.kind = kind;
  row.probability = probability;
  return row;
}

/// What would have to be measured so that the next record tells: the input whose gain is least known, or a sensor where no input follows the channel.
NextMeasurement needed(const DataRecord& record, const Judged& judged, Index target, const Days& parts, double signal) {
  const std::vector<Index> later = joined(parts.middle, parts.last);
  const std::string& channel = record.channels[static_cast<std::size_t>(target)].id;
  const MatrixXd columns = judged.box.columns(record)(later, Eigen::all), told = columns * judged.box.covariance;
  const double by_gains = std::sqrt(told.cwiseProduct(columns).rowwise().sum().mean());
  NextMeasurement next;
  next.channel = channel;
  const std::string goal = fmt::format("the expected spread has to fall from {:.3g} um below {:.3g} um, half of what {} varies by", judged.expected, too_wide * signal, channel);
  if (by_gains < std::hypot(judged.box.wander_std, judged.box.noise_std)) {
    next.load = "the same use, with a further temperature where its heat passes";
    next.why = fmt::format("no recorded input follows {:.3g} um of it in the part that is fitted; {}", judged.box.wander_std, goal);
    return next;
  }
  // How much narrower the prediction would be with one gain known.
  Index least_known = 0;
  double most = -1.0;
  for (Index i = 0; i < record.inputs.cols(); ++i)
    if (const double share = told.col(i).squaredNorm() / std::max(judged.box.covariance(i, i), 1e-300); share > most) most = share, least_known = i;
  const auto input = static_cast<std::size_t>(least_known);
  const VectorXd all = record.inputs.col(least_known), first = all(parts.first);
  const double fitted_hours = (parts.first_end - record.time[0]) / hour;
  next.load = fmt::format("a longer use in which {} moves over {:.4g} to {:.4g} {} apart from the other inputs while the model is fitted (here {:.4g} to {:.4g} in the first {:.0f} h)",
                          record.input_names[input], all.minCoeff(), all.maxCoeff(), record.input_units[input], first.minCoeff(), first.maxCoeff(), fitted_hours);
  next.why = fmt::format("its gain is known to {:.3g} +- {:.2g} um per {} only; {}", judged.box.gains[least_known], std::sqrt(judged.box.covariance(least_known, least_known)),
                         record.input_units[input], goal);
  return next;
}

std::string what_is_known(const DataRecord& record, const Judged& judged, const std::string& channel, const std::vector<Index>& later) {
  const VectorXd residual = judged.before(later);
  double strongest = 0.0;
  std::string follows;
  for (Index i = 0; i < record.inputs.cols(); ++i)
    if (const double r = correlation(record.inputs.col(i)(later), residual); std::abs(r) > std::abs(strongest))
      strongest = r, follows = record.input_names[static_cast<std::size_t>(i)];
  const VectorXd since = record.time(later).array() - record.time[later.front()];
  const double memory = memory_of(judged.before, later, record.interval), length = since[since.size() - 1];
  return fmt::format("{}: RMS after the first part {:.2f} against {:.2f} expected, mean {:+.2f}, {:+.3f} per hour, {}, correlation {:+.2f} with {}",
                     channel, judged.seen, judged.expected, residual.mean(),
                     since.size() > 2 ? (since.array() - since.mean()).matrix().dot((residual.array() - residual.mean()).matrix()) /
                                            (since.array() - since.mean()).square().sum() * hour : 0.0,
                     memory < length ? fmt::format("forgets itself in {:.1f} h", memory / hour) : fmt::format("does not forget itself within {:.1f} h", length / hour),
                     strongest, follows);
}

}  // namespace

Diagnosis diagnose_data(const compensation::Measurement& measurement, const DiagnoseOptions& options) {
  const DataRecord record = data_record(measurement, options.interval_s);
  const Days parts = divide(record);
  Diagnosis d;
  d.measurement = measurement.folder.filename().string();
  d.heldout_from_s = parts.last_start;
  const double fitted_hours = (parts.first_end - record.time[0]) / hour;
  const Index n = record.time.size(), targets = record.targets.cols();
  d.series.source = "residuals.csv";
  d.series.columns = {"time_s"};
  d.series.values.resize(n, 1 + 4 * targets);
  d.series.values.col(0) = record.time;

  std::vector<double> signals;
  bool any_moves = false;
  for (Index t = 0; t < targets; ++t) {
    signals.push_back(spread_of(record.targets.col(t)));
    any_moves = any_moves || signals.back() > moves * record.channels[static_cast<std::size_t>(t)].uncertainty;
  }
  bool all_none = true, unexplained = false, all_shared = true;
  std::vector<std::string> untold;  // channels of which the record cannot tell
  double widest = 0.0;
  std::string width;
  std::vector<RankedCause> rivals;
  double square_before = 0, square_after = 0, count = 0, none = 1.0, unknown = 0.0;
  VectorXd pooled_before = VectorXd::Zero(n), pooled_after = VectorXd::Zero(n);
  for (Index t = 0; t < targets; ++t) {
    const compensation::MeasuredChannel& channel = record.channels[static_cast<std::size_t>(t)];
    Judged judged = judge_channel(record, t, parts);
    const std::vector<Index> last = finite_rows(record.targets.col(t), parts.last), later = finite_rows(record.targets.col(t), joined(parts.middle, parts.last));
    const double signal = signals[static_cast<std::size_t>(t)], rms_before = root_mean_square(judged.before(last));
    const bool discrepancy = judged.p_value < discrepant;
    // One that stays beside others that move has nothing to tell.
    const bool untold_here = cannot_tell(judged, signal) && (signal > moves * channel.uncertainty || !any_moves);
    std::size_t best = 0;
    for (std::size_t i = 0; i < judged.extensions.size(); ++i)
      if (judged.probability[i] > judged.probability[best]) best = i;
    if (discrepancy || untold_here) {
      all_none = false;
      const std::vector<OnLastPart> last_part = on_last_part(record, t, judged, last);
      const Extension& leading = judged.extensions[best];
      const OnLastPart& led = last_part[best];
      const bool holds = led.gain.low > 0.0, names = discrepancy && holds && judged.probability[best] >= sure, open = untold_here && !names;
      d.notes.push_back(fmt::format("{}: {} (probability {:.2f}) changes the last part's RMS from {:.2f} to {:.2f} ({} %, 95 % interval {} to {}): {}.",
                                    channel.id, leading.kind, judged.probability[best], rms_before, led.rms, percent_text(led.explained_percent),
                                    percent_text(led.gain.low), percent_text(led.gain.high), holds ? "it holds" : "it does not hold there"));
      d.notes.push_back(what_is_known(record, judged, channel.id, later) + ".");
      std::vector<std::size_t> holding;
      for (std::size_t i = 0; i < judged.extensions.size(); ++i)
        if (last_part[i].gain.low > 0.0 && (i == best || judged.probability[i] >= shares)) holding.push_back(i);
      if (open) keep_prior(judged);
      const auto cause = [&](std::size_t i) { return ranked(judged.extensions[i], channel.id, judged.probability[i], last_part[i].explained_percent); };
      for (std::size_t i = 0; i < judged.extensions.size(); ++i) d.ranking.push_back(cause(i));
      // None, where all later hours refuse it: what it had on the middle part alone is nobody's.
      none = open ? std::min(none, judged.probability_none) : 0.0;
      unknown = std::max(unknown, judged.probability_unknown + (open ? 0.0 : judged.probability_none));
      if (names) {
        d.causes.push_back(cause(best));
        judged.after = record.targets.col(t) - leading.predicted;
      } else if (open) {
        untold.push_back(channel.id);
        if (discrepancy)
          for (const std::size_t i : holding) rivals.push_back(cause(i));
        d.notes.push_back(fmt::format("{}: its expected spread of {:.3g} {} after the first part is more than half of the {:.3g} {} by which it varies, so a discrepancy would not show.",
                                      channel.id, judged.expected, channel.unit, signal, channel.unit));
        if (judged.expected / std::max(signal, 1e-12) > widest) {
          widest = judged.expected / std::max(signal, 1e-12);
          width = fmt::format("{} is expected within +- {:.3g} {} and varies by {:.3g} {}", channel.id, judged.expected, channel.unit, signal, channel.unit);
          d.next = needed(record, judged, t, parts, signal);
        }
      } else {
        unexplained = true;
        all_shared = all_shared && !holding.empty() && judged.probability_unknown < 0.5;
        for (const std::size_t i : holding) rivals.push_back(cause(i));
      }
    }
    std::string elements;
    for (Index i = 0; i < record.inputs.cols(); ++i)
      elements += fmt::format("{}{:+.2f} {} ({:.1f} h)", i > 0 ? ", " : "", judged.box.gains[i], record.input_names[static_cast<std::size_t>(i)],
                              judged.box.time_constants[i] / hour);
    d.notes.push_back(fmt::format("Grey box of {} on the first {:.0f} h, gain per unit and time constant: {}.", channel.id,
                                  fitted_hours, elements));
    ChannelResidual residual;
    residual.id = channel.id;
    residual.unit = channel.unit;
    residual.uncertainty = channel.uncertainty;
    residual.rms_before = root_mean_square(judged.before(last));
    residual.rms_after = root_mean_square(judged.after(last));
    residual.explained_std = root_mean_square(judged.expected_std(last));
    residual.p_value_white = white_noise_p_value(judged.before(finite_rows(record.targets.col(t), parts.first)));
    d.residuals.push_back(residual);
    for (const Index row : last) {
      pooled_before[row] += judged.before[row] * judged.before[row];
      pooled_after[row] += judged.after[row] * judged.after[row];
      square_before += judged.before[row] * judged.before[row];
      square_after += judged.after[row] * judged.after[row];
      count += 1.0;
    }
    for (const char* suffix : {"", "_before", "_after", "_std"}) d.series.columns.push_back(channel.id + suffix);
    d.series.values.middleCols(1 + 4 * t, 4) << record.targets.col(t), judged.before, judged.after, judged.expected_std;
  }
  d.ranking.push_back(no_cause("none", none));
  d.ranking.push_back(no_cause("unknown", unknown));
  std::stable_sort(d.ranking.begin(), d.ranking.end(), [](const auto& a, const auto& b) { return a.probability > b.probability; });

  d.heldout_rms_before_um = std::sqrt(square_before / std::max(count, 1.0));
  d.heldout_rms_after_um = std::sqrt(square_after / std::max(count, 1.0));
  d.reduction_percent = reduction_percent(d.heldout_rms_before_um, d.heldout_rms_after_um);
  const Interval ci = reduction_interval(pooled_before(parts.last), pooled_after(parts.last), static_cast<Index>(std::lround(2.0 * hour / record.interval)));
  d.ci95_low_percent = ci.low;
  d.ci95_high_percent = ci.high;
  std::vector<std::string> named, shared;
  for (const RankedCause& cause : d.causes) named.push_back(cause.parameter.kind + " of " + cause.parameter.where);
  for (const RankedCause& cause : rivals) shared.push_back(cause.parameter.kind + " of " + cause.parameter.where);
  const std::string beside = named.empty() ? "" : fmt::format(" {} explains the rest.", core::join(named));
  if (all_none) {
    d.verdict = "no_discrepancy";
    d.sentence = fmt::format("No discrepancy: the record follows the grey box of its first {:.0f} h within its uncertainty.", fitted_hours);
  } else if (unexplained && !all_shared) {
    d.verdict = "unexplained";
    d.sentence = fmt::format("Unexplained: the grey box of the first {:.0f} h misses what follows, and {}; the notes say how they differ.", fitted_hours,
                             named.empty() ? "nothing proposed holds in the last part" : "only " + core::join(named) + " holds in the last part");
  } else if (unexplained) {
    d.verdict = "ambiguous";
    d.sentence = fmt::format("Ambiguous: the grey box of the first {:.0f} h misses what follows; {} or something unknown explains it.{}", fitted_hours, core::join(shared), beside);
  } else if (!untold.empty()) {
    d.verdict = "ambiguous";
    d.sentence = fmt::format("This record cannot tell whether {} changed after its first {:.0f} h: {} (one standard deviation each).{} To decide, measure {} under {}: {}.",
                             core::join(untold), fitted_hours, width, beside, d.next.channel, d.next.load, d.next.why);
  } else {
    d.verdict = "explained";
    d.sentence = fmt::format("Explained by {}: in the last part the displacements' RMS goes from {:.2f} to {:.2f} um.", core::join(named), d.heldout_rms_before_um,
                             d.heldout_rms_after_um);
  }
  if (d.verdict == "ambiguous") {
    if (!unexplained) d.ambiguous_set.push_back(no_cause("none", none));
    d.ambiguous_set.insert(d.ambiguous_set.end(), rivals.begin(), rivals.end());
    d.ambiguous_set.push_back(no_cause("unknown", unknown));
  }
  return d;
}

}  // namespace thermotwin::diagnosis
