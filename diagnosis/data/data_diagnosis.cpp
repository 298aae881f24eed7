// SPDX-License-Identifier: GPL-3.0-or-later
// What is wrong with a grey box on the days after the one it was fitted on, what may explain it, and
// whether that holds on the last day.

#include "diagnosis/data/data_diagnosis.h"

#include <fmt/format.h>
#include <iterator>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/text.h"
#include "diagnosis/data/data_hypotheses.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/report/words.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double hour = 3600.0;
constexpr double sure = 0.9, discrepant = 0.01;  ///< probability of a cause; p value of a residual
constexpr double too_wide =
    0.5;  ///< expected spread over a channel's own, above which a discrepancy as large as the signal would pass
constexpr double shares = 0.05;  ///< probability of a cause that stays in an ambiguous set
constexpr double doubtful =
    0.1;                       ///< probability of none, below which a record without a discrepancy is not called clean
constexpr double moves = 2.0;  ///< times its uncertainty, by which a channel varies that has something to be explained

/// Time by which a residual forgets itself, from its correlation one interval apart; s. Infinite where it does not.
double memory_of(const VectorXd& residual, const std::vector<Index>& rows, double interval) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i] != rows[i - 1] + 1) continue;
    product += residual[rows[i]] * residual[rows[i - 1]];
    square += 0.5 * (residual[rows[i]] * residual[rows[i]] + residual[rows[i - 1]] * residual[rows[i - 1]]);
  }
  const double correlation = square > 0.0 ? product / square : 0.0;
  return correlation >= 1.0  ? std::numeric_limits<double>::infinity()
         : correlation > 0.0 ? -interval / std::log(correlation)
                             : 0.0;
}

double correlation(const VectorXd& a, const VectorXd& b) {
  const VectorXd x = a.array() - a.mean(), y = b.array() - b.mean();
  const double size = x.norm() * y.norm();
  return size > 0.0 ? x.dot(y) / size : 0.0;
}

/// A record that cannot tell leaves every probability at its prior: its noise was learnt where too little happened.
void keep_prior(JudgedChannel& judged) {
  judged.none = prior_none;
  judged.unknown = prior_unknown;
  for (Extension& extension : judged.extensions)
    extension.probability = prior_cause / static_cast<double>(judged.extensions.size());
}

/// The first part leaves so much open that a discrepancy of the signal's own size would pass, and none larger shows.
bool cannot_tell(const JudgedChannel& judged, double signal) {
  return judged.expected > too_wide * signal && judged.seen <= 2.0 * judged.expected;
}

/// Sums of squares per interval of the last part.
Interval last_interval(const VectorXd& before, const VectorXd& after, const std::vector<Index>& rows, double interval) {
  return reduction_interval(before(rows).cwiseAbs2(), after(rows).cwiseAbs2(),
                            static_cast<Index>(std::lround(2.0 * hour / interval)));
}

/// @param explained_percent  of the channel's RMS in the last part
RankedCause ranked(const Extension& extension, const std::string& channel, double explained_percent) {
  RankedCause cause;
  cause.parameter.kind = extension.kind;
  cause.parameter.where = channel;
  cause.parameter.name = extension.name;
  cause.parameter.unit = extension.unit;
  cause.parameter.ratio = false;
  cause.parameter.nominal = 0.0;
  cause.probability = extension.probability;
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

std::vector<OnLastPart> on_last_part(const DataRecord& record, Index target, const JudgedChannel& judged,
                                     const std::vector<Index>& last) {
  std::vector<OnLastPart> all;
  for (const Extension& extension : judged.extensions) {
    const VectorXd after = record.targets.col(target) - extension.predicted;
    const double rms = root_mean_square(after(last));
    all.push_back({rms, reduction_percent(root_mean_square(judged.before(last)), rms),
                   last_interval(judged.before, after, last, record.interval)});
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

/// In words, with when it begins.
std::string described(const Extension& extension) {
  if (extension.kind != "probe_drift") return extension.kind;
  return fmt::format("{} of {:+.3g} +- {:.2g} {} from hour {:.0f} on", extension.kind, extension.value, extension.std,
                     extension.unit, extension.begins / hour);
}

/// What would have to be measured so that the next record tells: the input whose gain is least known, or a sensor where no input follows the channel.
NextMeasurement needed(const DataRecord& record, const JudgedChannel& judged, Index target, const RecordParts& parts,
                       double signal) {
  const std::vector<Index> later = joined(parts.middle, parts.last);
  const std::string& channel = record.channels[target].id;
  const MatrixXd columns = judged.box.columns(record)(later, Eigen::all), told = columns * judged.box.covariance;
  const double by_gains = std::sqrt(told.cwiseProduct(columns).rowwise().sum().mean());
  NextMeasurement next;
  next.channel = channel;
  const std::string goal =
      fmt::format("the expected spread has to fall from {:.3g} um below {:.3g} um, half of what {} varies by",
                  judged.expected, too_wide * signal, channel);
  if (by_gains < std::hypot(judged.box.wander_std, root_mean_square(judged.box.noise_std(later)))) {
    next.load = "the same use, with a further temperature where its heat passes";
    next.why = fmt::format("no recorded input follows {:.3g} um of it in the part that is fitted; {}",
                           judged.box.wander_std, goal);
    return next;
  }
  // How much narrower the prediction would be with one input's gains known.
  const Index elements = std::ssize(judged.box.time_constants);
  Index least_known = 0;
  double most = -1.0;
  for (Index i = 0; i < record.inputs.cols(); ++i) {
    const MatrixXd own = columns.middleCols(i * elements, elements);
    const MatrixXd told_own = own * judged.box.covariance.block(i * elements, i * elements, elements, elements);
    if (const double share = told_own.cwiseProduct(own).sum(); share > most) most = share, least_known = i;
  }
  const std::size_t input = least_known;
  const VectorXd all = record.inputs.col(least_known), first = all(parts.first);
  const double fitted_hours = (parts.first_end - record.time[0]) / hour;
  next.load = fmt::format(
      "a longer use in which {} moves over {:.4g} to {:.4g} {} apart from the other inputs while the model is fitted "
      "(here {:.4g} to {:.4g} in the first {:.0f} h)",
      record.input_names[input], all.minCoeff(), all.maxCoeff(), record.input_units[input], first.minCoeff(),
      first.maxCoeff(), fitted_hours);
  const auto own = judged.box.covariance.block(least_known * elements, least_known * elements, elements, elements);
  next.why = fmt::format("its steady gain is known to {:.3g} +- {:.2g} um per {} only; {}",
                         judged.box.step_response(least_known, std::numeric_limits<double>::infinity()),
                         std::sqrt(std::max(own.sum(), 0.0)), record.input_units[input], goal);
  return next;
}

std::string what_is_known(const DataRecord& record, const JudgedChannel& judged, const std::string& channel,
                          const std::vector<Index>& later) {
  const VectorXd residual = judged.before(later);
  double strongest = 0.0;
  std::string follows;
  for (Index i = 0; i < record.inputs.cols(); ++i)
    if (const double r = correlation(record.inputs.col(i)(later), residual); std::abs(r) > std::abs(strongest))
      strongest = r, follows = record.input_names[i];
  const VectorXd since = record.time(later).array() - record.time[later.front()];
  const double memory = memory_of(judged.before, later, record.interval), length = since[since.size() - 1];
  return fmt::format(
      "{}: RMS after the first part {:.2f} against {:.2f} expected, mean {:+.2f}, {:+.3f} per hour, {}, correlation "
      "{:+.2f} with {}",
      channel, judged.seen, judged.expected, residual.mean(),
      since.size() > 2 ? (since.array() - since.mean()).matrix().dot((residual.array() - residual.mean()).matrix()) /
                             (since.array() - since.mean()).square().sum() * hour
                       : 0.0,
      memory < length ? fmt::format("forgets itself in {:.1f} h", memory / hour)
                      : fmt::format("does not forget itself within {:.1f} h", length / hour),
      strongest, follows);
}

/// @throws InputError where a displacement has no value to fit, to compare or to judge
void refuse_empty_parts(const DataRecord& record, const RecordParts& parts, const std::string& place) {
  for (Index t = 0; t < record.targets.cols(); ++t)
    for (const std::vector<Index>* part : {&parts.first, &parts.middle, &parts.last})
      if (finite_rows(record.targets.col(t), *part).empty())
        throw core::InputError(place,
                               fmt::format("no value of {} from hour {:.3g} to {:.3g}", record.channels[t].id,
                                           (record.time[part->front()] - record.time[0]) / hour,
                                           (record.time[part->back()] - record.time[0]) / hour),
                               "displacements with values in each part: one to fit, one to compare and one to judge; "
                               "leave the channel out of channels.toml");
}

}  // namespace

Diagnosis diagnose_data(const compensation::Measurement& measurement, const DiagnoseOptions& options) {
  const DataRecord record = data_record(measurement, options.interval_s);
  const RecordParts parts = divide(record);
  refuse_empty_parts(record, parts, measurement.folder.string());
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
    any_moves = any_moves || signals.back() > moves * record.channels[t].uncertainty;
  }
  bool all_none = true, unexplained = false, all_shared = true;
  std::vector<std::string> untold, doubted;  // channels of which the record cannot tell; where none is not likely
  double widest = 0.0;
  std::string width;
  std::vector<RankedCause> rivals;
  double square_before = 0, square_after = 0, count = 0, none = 1.0, unknown = 0.0;
  VectorXd pooled_before = VectorXd::Zero(n), pooled_after = VectorXd::Zero(n);
  for (Index t = 0; t < targets; ++t) {
    const compensation::MeasuredChannel& channel = record.channels[t];
    JudgedChannel judged = judge_channel(record, t, parts);
    VectorXd after_extension = judged.before;  // of a named cause
    const std::vector<Index> last = finite_rows(record.targets.col(t), parts.last),
                             later = finite_rows(record.targets.col(t), joined(parts.middle, parts.last));
    const double signal = signals[t], rms_before = root_mean_square(judged.before(last));
    const bool discrepancy = judged.p_value < discrepant;
    // One that stays beside others that move has nothing to tell.
    const bool untold_here = cannot_tell(judged, signal) && (signal > moves * channel.uncertainty || !any_moves);
    std::size_t best = 0;
    for (std::size_t i = 0; i < judged.extensions.size(); ++i)
      if (judged.extensions[i].probability > judged.extensions[best].probability) best = i;
    const bool doubt = !discrepancy && judged.none < doubtful;
    if (!(discrepancy || untold_here || doubt)) {
      none = std::min(none, judged.none);
      unknown = std::max(unknown, judged.unknown);
    } else {
      all_none = false;
      const std::vector<OnLastPart> last_part = on_last_part(record, t, judged, last);
      const Extension& leading = judged.extensions[best];
      const OnLastPart& led = last_part[best];
      const bool holds = led.gain.low > 0.0, names = discrepancy && holds && leading.probability >= sure;
      const bool open = (untold_here || doubt) && !names;
      d.notes.push_back(fmt::format(
          "{}: {} (probability {:.2f}) changes the last part's RMS from {:.2f} to {:.2f} ({} %, 95 % interval {} to "
          "{}): {}.",
          channel.id, described(leading), leading.probability, rms_before, led.rms, percent_text(led.explained_percent),
          percent_text(led.gain.low), percent_text(led.gain.high), holds ? "it holds" : "it does not hold there"));
      d.notes.push_back(what_is_known(record, judged, channel.id, later) + ".");
      std::vector<std::size_t> holding;
      for (std::size_t i = 0; i < judged.extensions.size(); ++i)
        if (last_part[i].gain.low > 0.0 && (i == best || judged.extensions[i].probability >= shares))
          holding.push_back(i);
      if (open && untold_here) keep_prior(judged);
      const auto cause = [&](std::size_t i) {
        return ranked(judged.extensions[i], channel.id, last_part[i].explained_percent);
      };
      for (std::size_t i = 0; i < judged.extensions.size(); ++i) d.ranking.push_back(cause(i));
      // None, where all later hours refuse it: what it had on the middle part alone is nobody's.
      none = open ? std::min(none, judged.none) : 0.0;
      unknown = std::max(unknown, judged.unknown + (open ? 0.0 : judged.none));
      if (names) {
        d.causes.push_back(cause(best));
        after_extension = record.targets.col(t) - leading.predicted;
      } else if (open) {
        for (const std::size_t i : holding)
          if (discrepancy || !untold_here) rivals.push_back(cause(i));
        if (!untold_here) {
          doubted.push_back(channel.id);
          d.notes.push_back(
              fmt::format("{}: what follows lies within what is expected, but that nothing changed has a probability "
                          "of {:.2f} only.",
                          channel.id, judged.none));
        } else {
          untold.push_back(channel.id);
          d.notes.push_back(
              fmt::format("{}: its expected spread of {:.3g} {} after the first part is more than half of the {:.3g} "
                          "{} by which it varies, so a discrepancy would not show.",
                          channel.id, judged.expected, channel.unit, signal, channel.unit));
        }
        if (const double wide = judged.expected / std::max(signal, 1e-12); untold_here && wide > widest) {
          widest = wide;
          width = fmt::format("{} is expected within +- {:.3g} {} and varies by {:.3g} {}", channel.id, judged.expected,
                              channel.unit, signal, channel.unit);
          d.next = needed(record, judged, t, parts, signal);
        }
      } else {
        unexplained = true;
        all_shared = all_shared && !holding.empty() && judged.unknown < 0.5;
        for (const std::size_t i : holding) rivals.push_back(cause(i));
      }
    }
    std::string steps;
    for (Index i = 0; i < record.inputs.cols(); ++i) {
      steps += fmt::format("{}per {} of {}", i > 0 ? "; " : "", record.input_units[i], record.input_names[i]);
      for (const double share : {1.0 / 24.0, 0.25, 1.0})
        steps += fmt::format(" {:+.2f} ({:.3g} h)", judged.box.step_response(i, share * fitted_hours * hour),
                             share * fitted_hours);
    }
    d.notes.push_back(fmt::format("Grey box of {} on the first {:.0f} h, {} moved so long after a step: {}.",
                                  channel.id, fitted_hours, channel.unit, steps));
    ChannelResidual residual;
    residual.id = channel.id;
    residual.unit = channel.unit;
    residual.uncertainty = channel.uncertainty;
    residual.rms_before = root_mean_square(judged.before(last));
    residual.rms_after = root_mean_square(after_extension(last));
    residual.explained_std = root_mean_square(judged.expected_std(last));
    residual.p_value_white = white_noise_p_value(judged.before(finite_rows(record.targets.col(t), parts.first)));
    d.residuals.push_back(residual);
    for (const Index row : last) {
      pooled_before[row] += judged.before[row] * judged.before[row];
      pooled_after[row] += after_extension[row] * after_extension[row];
      square_before += judged.before[row] * judged.before[row];
      square_after += after_extension[row] * after_extension[row];
      count += 1.0;
    }
    for (const char* suffix : {"", "_before", "_after", "_std"}) d.series.columns.push_back(channel.id + suffix);
    d.series.values.middleCols(1 + 4 * t, 4) << record.targets.col(t), judged.before, after_extension,
        judged.expected_std;
  }
  d.ranking.push_back(no_cause("none", none));
  d.ranking.push_back(no_cause("unknown", unknown));
  std::stable_sort(d.ranking.begin(), d.ranking.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });

  d.heldout_rms_before_um = std::sqrt(square_before / std::max(count, 1.0));
  d.heldout_rms_after_um = std::sqrt(square_after / std::max(count, 1.0));
  d.reduction_percent = reduction_percent(d.heldout_rms_before_um, d.heldout_rms_after_um);
  const Interval ci = reduction_interval(pooled_before(parts.last), pooled_after(parts.last),
                                         static_cast<Index>(std::lround(2.0 * hour / record.interval)));
  d.ci95_low_percent = ci.low;
  d.ci95_high_percent = ci.high;
  std::vector<std::string> named, shared;
  for (const RankedCause& cause : d.causes) named.push_back(cause.parameter.kind + " of " + cause.parameter.where);
  for (const RankedCause& cause : rivals) shared.push_back(cause.parameter.kind + " of " + cause.parameter.where);
  const std::string beside = named.empty() ? "" : fmt::format(" {} explains the rest.", core::join(named));
  if (all_none) {
    d.verdict = "no_discrepancy";
    d.sentence = fmt::format(
        "No discrepancy: the record follows the grey box of its first {:.0f} h within its uncertainty.", fitted_hours);
  } else if (unexplained && !all_shared) {
    d.verdict = "unexplained";
    d.sentence = fmt::format(
        "Unexplained: the grey box of the first {:.0f} h misses what follows, and {}; the notes say how they differ.",
        fitted_hours,
        named.empty() ? "nothing proposed holds in the last part"
                      : "only " + core::join(named) + " holds in the last part");
  } else if (unexplained) {
    d.verdict = "ambiguous";
    d.sentence = fmt::format(
        "Ambiguous: the grey box of the first {:.0f} h misses what follows; {} or something unknown explains it.{}",
        fitted_hours, core::join(shared), beside);
  } else if (!doubted.empty() && untold.empty()) {
    d.verdict = "ambiguous";
    d.sentence = fmt::format(
        "Ambiguous: {} follows the grey box of the first {:.0f} h within its uncertainty, but {} may have changed "
        "it.{}",
        core::join(doubted), fitted_hours, shared.empty() ? "something that the notes describe" : core::join(shared),
        beside);
  } else if (!untold.empty()) {
    d.verdict = "ambiguous";
    d.sentence = fmt::format(
        "This record cannot tell whether {} changed after its first {:.0f} h: {} (one standard deviation each).{} To "
        "decide, measure {} under {}: {}.",
        core::join(untold), fitted_hours, width, beside, d.next.channel, d.next.load, d.next.why);
  } else {
    d.verdict = "explained";
    d.sentence = fmt::format("Explained by {}: in the last part the displacements' RMS goes from {:.2f} to {:.2f} um.",
                             core::join(named), d.heldout_rms_before_um, d.heldout_rms_after_um);
  }
  if (d.verdict == "ambiguous") {
    if (!unexplained) d.ambiguous_set.push_back(no_cause("none", none));
    d.ambiguous_set.insert(d.ambiguous_set.end(), rivals.begin(), rivals.end());
    d.ambiguous_set.push_back(no_cause("unknown", unknown));
  }
  return d;
}

}  // namespace thermotwin::diagnosis
