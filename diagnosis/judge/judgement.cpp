// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/reservations.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double bootstrap_block_s = 2.0 * core::units::hour;
constexpr double surely_worse = -0.5;   ///< percent: upper end of a gain's interval
constexpr double least_removed = 0.05;  ///< of a mean square: less is nothing
constexpr double much_worse = 1.5;      ///< RMS after over before: a wrong cause, not one that wanders

/// Held-out sums of squares per interval of the channels that a rule picks.
struct Squares {
  VectorXd before, after;
  double count = 0;
};

template <class Pick>
Squares heldout_squares(const Problem& problem, const VectorXd& predicted, const Pick& pick) {
  const Observations& obs = problem.observations;
  const VectorXd before = problem.settled(problem.predicted), after = problem.settled(predicted);
  Squares all{VectorXd::Zero(obs.intervals), VectorXd::Zero(obs.intervals), 0};
  std::vector<Index> first(obs.each().size(), obs.intervals);  // held-out interval of each record
  for (std::size_t k = 0; k < obs.channels.size(); ++k) {
    const ObservedChannel& channel = obs.channels[k];
    if (!pick(channel)) continue;
    const Index row = problem.first_row(k);
    for (Index i = channel.fitted; i < channel.size(); ++i) {
      const Index interval = channel.interval[i];
      all.before[interval] += std::pow(problem.measured[row + i] - before[row + i], 2);
      all.after[interval] += std::pow(problem.measured[row + i] - after[row + i], 2);
      all.count += 1.0;
      first[channel.record] = std::min(first[channel.record], interval);
    }
  }
  std::vector<Index> heldout;
  for (std::size_t r = 0; r < first.size(); ++r) {
    const Observations& record = obs.each()[r];
    for (Index i = first[r]; i < record.offset.interval + record.intervals; ++i) heldout.push_back(i);
  }
  all.before = all.before(heldout).eval();
  all.after = all.after(heldout).eval();
  return all;
}

Interval interval_of(const Problem& problem, const Squares& squares) {
  return reduction_interval(squares.before, squares.after,
                            std::lround(bootstrap_block_s / problem.observations.interval));
}

bool is_gauge(const ObservedChannel& channel) { return channel.is_gauge(); }

/// RMS of what the hypothesis changes in the displacements, um: fitted, held out.
std::pair<double, double> effects_um(const Problem& problem, const Hypothesis& best) {
  double sums[2] = {0.0, 0.0}, counts[2] = {0.0, 0.0};
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const ObservedChannel& channel = problem.observations.channels[k];
    if (!is_gauge(channel)) continue;
    const VectorXd change =
        (best.predicted - problem.predicted).segment(problem.first_row(k), channel.size()).cwiseAbs2();
    sums[0] += change.head(channel.fitted).sum();
    sums[1] += change.tail(channel.size() - channel.fitted).sum();
    counts[0] += channel.fitted;
    counts[1] += channel.size() - channel.fitted;
  }
  const auto rms = [&](int i) { return counts[i] > 0.0 ? std::sqrt(sums[i] / counts[i]) : 0.0; };
  return {rms(0), rms(1)};
}

void fill_series(const Problem& problem, const Hypothesis& best, Diagnosis& out) {
  const Observations& obs = problem.observations;
  const VectorXd before = problem.settled(problem.predicted), after = problem.settled(best.predicted);
  const auto channels = std::ssize(obs.channels);
  out.series.source = "residuals.csv";
  out.series.columns = {"time_s"};
  out.series.values.setConstant(obs.intervals, 1 + 4 * channels, std::numeric_limits<double>::quiet_NaN());
  out.records.clear();
  for (const Observations& record : obs.each()) {
    for (Index i = 0; i < record.intervals; ++i)
      out.series.values(record.offset.interval + i, 0) =
          std::min(record.start + record.interval * (i + 0.5), record.end);
    if (!obs.records.empty()) {
      DiagnosedRecord one{.name = record.name, .from_s = record.start, .to_s = record.end};
      one.heldout_from_s = record.split;
      one.first_row = record.offset.interval;
      one.rows = record.intervals;
      const Squares gauges = heldout_squares(problem, best.predicted, [&](const ObservedChannel& channel) {
        return is_gauge(channel) && channel.record_name == record.name;
      });
      if (gauges.count > 0.0) {
        one.rms_before_um = std::sqrt(gauges.before.sum() / gauges.count);
        one.rms_after_um = std::sqrt(gauges.after.sum() / gauges.count);
      }
      out.records.push_back(std::move(one));
    }
  }
  for (Index k = 0; k < channels; ++k) {
    const ObservedChannel& channel = obs.channels[k];
    for (const char* suffix : {"", "_before", "_after", "_std"})
      out.series.columns.push_back(channel.channel.id + suffix);
    const Index row = problem.first_row(k);
    for (Index i = 0; i < channel.size(); ++i) {
      const Index at = channel.interval[i];
      out.series.values.row(at).segment(1 + 4 * k, 4) << problem.measured[row + i],
          problem.measured[row + i] - before[row + i], problem.measured[row + i] - after[row + i],
          problem.expected_std[row + i];
    }
  }
  if (out.records.empty()) return;
  out.series.columns.emplace_back("record");
  out.series.values.conservativeResize(Eigen::NoChange, std::ssize(out.series.columns));
  for (std::size_t r = 0; r < out.records.size(); ++r) {
    out.series.values.rightCols(1).middleRows(out.records[r].first_row, out.records[r].rows).setConstant(r + 1);
  }
}

}  // namespace

double heldout_explained_percent(const Problem& problem, const VectorXd& predicted) {
  const VectorXd without = problem.measured - problem.settled(problem.predicted),
                 with = problem.measured - problem.settled(predicted);
  double before = 0.0, after = 0.0;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const ObservedChannel& channel = problem.observations.channels[k];
    const Index first = problem.first_row(k) + channel.fitted, n = channel.size() - channel.fitted;
    const Eigen::ArrayXd weight = problem.expected_std.segment(first, n).array().inverse();
    before += (without.segment(first, n).array() * weight).square().sum();
    after += (with.segment(first, n).array() * weight).square().sum();
  }
  return before > 0.0 ? 100.0 * (1.0 - after / before) : 0.0;
}

double heldout_misfit(const Problem& problem, const Hypothesis& h, const std::vector<std::size_t>& unknown_channels) {
  const bool readings_only = std::all_of(h.members.begin(), h.members.end(),
                                         [&](int i) { return acts_on_readings(problem.parameters[i].kind); });
  const auto counts = [&](const ObservedChannel& channel) {
    return !readings_only || std::any_of(h.members.begin(), h.members.end(),
                                         [&](int i) { return channel.is_called(problem.parameters[i].where); });
  };
  const VectorXd without = problem.settled(problem.predicted), with = problem.settled(h.predicted);
  double before = 0.0, after = 0.0, change = 0.0, change_fitted = 0.0, heldout = 0.0, fitted = 0.0;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const ObservedChannel& channel = problem.observations.channels[k];
    if (!counts(channel) || std::find(unknown_channels.begin(), unknown_channels.end(), k) != unknown_channels.end())
      continue;
    const Index first = problem.first_row(k), n = channel.size(), late = n - channel.fitted;
    const Eigen::ArrayXd weight = problem.expected_std.segment(first, n).array().inverse();
    const Eigen::ArrayXd off = (problem.measured - without).segment(first, n).array() * weight;
    const Eigen::ArrayXd moved = (with - without).segment(first, n).array() * weight;
    before += off.tail(late).square().sum();
    after += (off - moved).tail(late).square().sum();
    change += moved.tail(late).square().sum();
    change_fitted += moved.head(channel.fitted).square().sum();
    heldout += 1.0 * late;
    fitted += 1.0 * channel.fitted;
  }
  if (!(heldout > 0.0) || change / heldout < shows_little * shows_little * change_fitted / std::max(fitted, 1.0))
    return 0.0;
  const double share = std::max(least_removed, 1.0 - after / before);
  return std::max(0.0, h.log_evidence) * (1.0 - share) / share;
}

void judge(const Problem& problem, const Hypothesis& best, Diagnosis& out) {
  const VectorXd white = white_residual(problem, best), before = problem.measured - problem.settled(problem.predicted),
                 after = problem.measured - problem.settled(best.predicted);
  Index white_row = 0;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const ObservedChannel& channel = problem.observations.channels[k];
    const Index first = problem.first_row(k) + channel.fitted, n = channel.size() - channel.fitted;
    ChannelResidual residual;
    residual.id = channel.channel.id;
    residual.unit = channel.channel.unit;
    residual.record = channel.record;
    residual.uncertainty = channel.channel.uncertainty;
    residual.rms_before = root_mean_square(before.segment(first, n));
    residual.rms_after = root_mean_square(after.segment(first, n));
    residual.explained_std = root_mean_square(problem.expected_std.segment(first, n));
    residual.p_value_white = white_noise_p_value(white.segment(white_row, channel.fitted));
    white_row += channel.fitted;
    out.residuals.push_back(std::move(residual));
  }
  const Squares gauges = heldout_squares(problem, best.predicted, is_gauge);
  if (gauges.count > 0) {
    out.heldout_rms_before_um = std::sqrt(gauges.before.sum() / gauges.count);
    out.heldout_rms_after_um = std::sqrt(gauges.after.sum() / gauges.count);
    out.reduction_percent = reduction_percent(out.heldout_rms_before_um, out.heldout_rms_after_um);
    const Interval ci = interval_of(problem, gauges);
    out.ci95_low_percent = ci.low;
    out.ci95_high_percent = ci.high;
  }
  std::tie(out.effect_fitted_um, out.effect_heldout_um) = effects_um(problem, best);
  fill_series(problem, best, out);
}

std::string heldout_objection(const Diagnosis& d, double chi_square) {
  if (d.causes.empty()) return "";
  if (d.ci95_high_percent >= 0.0 || d.heldout_rms_after_um < much_worse * d.heldout_rms_before_um) return "";
  // A right cause makes things worse too where something else, within its uncertainty, had cancelled it: what comes is
  // then as expected.
  if (chi_square < not_foretold) return "";
  std::vector<std::string> names;
  for (const RankedCause& cause : d.causes) names.push_back(name_of(cause.parameter));
  return fmt::format(
      "{} fitted best, but worsened the displacements on held-out data ({:.2f} um after, {:.2f} um before): not named.",
      core::join(names), d.heldout_rms_after_um, d.heldout_rms_before_um);
}

std::string worsened(const Diagnosis& d) {
  if (d.heldout_rms_before_um > 0.0 && d.ci95_high_percent < surely_worse) {
    return fmt::format("correcting {} worsens the displacements on held-out data ({:.2f} um RMS after, {:.2f} before)",
                       d.causes.size() == 1 ? "it" : "them", d.heldout_rms_after_um, d.heldout_rms_before_um);
  }
  for (const ChannelResidual& r : d.residuals) {
    if (r.rms_after > much_worse * std::max(r.rms_before, r.explained_std)) {
      return fmt::format("correcting {} worsens {} on held-out data ({:.3g} {} RMS after, {:.3g} before)",
                         d.causes.size() == 1 ? "it" : "them", r.id, r.rms_after, r.unit, r.rms_before);
    }
  }
  return "";
}

std::string perhaps_unrecorded(const mesh::Machine& machine, const compensation::Measurement& measurement,
                               const Diagnosis& d) {
  for (const mesh::SourceSpec* source : unrecorded_sources(machine, measurement)) {
    for (const RankedCause& cause : d.causes) {
      if (cause.parameter.missing && heats(machine, *source, cause.parameter.missing->body)) {
        return fmt::format("{}.power_W is not recorded, and the heat of {} enters {} too", source->drive, source->id,
                           cause.parameter.missing->body);
      }
    }
  }
  return "";
}

bool worth_extending(const Problem& problem, const Hypothesis& best, const Diagnosis& diagnosis) {
  const bool sensors_only = std::all_of(diagnosis.causes.begin(), diagnosis.causes.end(),
                                        [](const RankedCause& c) { return acts_on_readings(c.parameter.kind); });
  const bool gauged = std::any_of(problem.observations.channels.begin(), problem.observations.channels.end(), is_gauge);
  if (!sensors_only && gauged) return diagnosis.ci95_low_percent > 0.0;
  const Squares squares = heldout_squares(problem, best.predicted, [&](const ObservedChannel& channel) {
    if (!sensors_only) return channel.is_temperature();
    return std::any_of(diagnosis.causes.begin(), diagnosis.causes.end(),
                       [&](const RankedCause& c) { return channel.is_called(c.parameter.where); });
  });
  return squares.count > 0 && interval_of(problem, squares).low > 0.0;
}

}  // namespace thermotwin::diagnosis
