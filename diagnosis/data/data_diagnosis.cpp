// SPDX-License-Identifier: GPL-3.0-or-later
// Does a record leave the lag model that was fitted on its first part, which extension may explain that, and does
// the extension hold in the last part?

#include "diagnosis/data/data_diagnosis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/data/channel_finding.h"
#include "diagnosis/data/sentences.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/report/words.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using core::units::hour;
/// RMS after the first part over the expected one, from which a residual within chance is given in numbers.
constexpr double worth_saying = 1.25;
constexpr double tells_nothing = 10.0;  ///< expected deviation over the signal: no prediction

/// @throws InputError where a displacement has no value to fit, to compare or to judge
void refuse_empty_segments(const DataRecord& record, const RecordSegments& segments, const std::string& place) {
  for (Index t = 0; t < record.targets.cols(); ++t) {
    for (const std::vector<Index>* part : {&segments.first, &segments.middle, &segments.last}) {
      if (finite_rows(record.targets.col(t), *part).empty()) {
        throw core::InputError(place,
                               fmt::format("no value of {} from hour {:.3g} to {:.3g}", record.channels[t].id,
                                           (record.time[part->front()] - record.time[0]) / hour,
                                           (record.time[part->back()] - record.time[0]) / hour),
                               "values in each of the three parts of the record (fitting, comparison, judgement); "
                               "leave the channel out of channels.toml");
      }
    }
  }
}

/// The lag model of a channel in words: the displacement some time after a step of each input.
std::string box_in_words(const DataRecord& record, const ChannelFinding& finding, double fitted_hours) {
  std::string steps;
  for (Index i = 0; i < record.inputs.cols(); ++i) {
    steps += fmt::format("{}per {} of {}", i > 0 ? "; " : "", record.input_units[i], record.input_names[i]);
    for (const double share : {1.0 / 24.0, 0.25, 1.0}) {
      steps += fmt::format(" {:+.2f} ({:.3g} h)", finding.weighed.model.step_response(i, share * fitted_hours * hour),
                           share * fitted_hours);
    }
  }
  return fmt::format("Lag model of {} on the first {:.0f} h, step responses in {} after the time in brackets: {}.",
                     finding.channel, fitted_hours, finding.unit, steps);
}

/// What all channels say together.
class Record {
public:
  Record(const DataRecord& record, const RecordSegments& segments) : record_(record), segments_(segments) {
    std::vector<double> signals;
    for (Index t = 0; t < record.targets.cols(); ++t) signals.push_back(spread_of(record.targets.col(t)));
    for (Index t = 0; t < record.targets.cols(); ++t)
      findings_.push_back(find_in_channel(record, segments, t, signals));
  }

  void add_channels(Diagnosis& d) const {
    // The channels that say something come first.
    for (const bool clean : {false, true}) {
      for (const ChannelFinding& finding : findings_) {
        if (finding.clean() != clean) continue;
        const std::vector<RankedCause> rows = ranking_of(finding);
        d.ranking.insert(d.ranking.end(), rows.begin(), rows.end());
      }
    }
    for (const ChannelFinding& finding : findings_) {
      if (finding.names()) d.causes.push_back(cause_of(finding, finding.best));
      if (!finding.clean()) add_notes(finding, d);
      d.notes.push_back(box_in_words(record_, finding, fitted_hours()));
      d.residuals.push_back(residual_of(finding));
    }
  }

  void add_series(Diagnosis& d) const {
    d.series.source = "residuals.csv";
    d.series.columns = {"time_s"};
    d.series.values.resize(record_.time.size(), 1 + 4 * std::ssize(findings_));
    d.series.values.col(0) = record_.time;
    for (const ChannelFinding& finding : findings_) {
      for (const char* suffix : {"", "_before", "_after", "_std"}) d.series.columns.push_back(finding.channel + suffix);
      d.series.values.middleCols(1 + 4 * finding.target, 4) << record_.targets.col(finding.target),
          finding.weighed.before, finding.after(record_), finding.weighed.expected_std;
    }
  }

  /// Of all channels on the last part.
  void add_gain(Diagnosis& d) const {
    const Index n = record_.time.size();
    VectorXd pooled_before = VectorXd::Zero(n), pooled_after = VectorXd::Zero(n);
    double square_before = 0.0, square_after = 0.0, count = 0.0;
    for (const ChannelFinding& finding : findings_) {
      const VectorXd after = finding.after(record_);
      for (const Index row : finding.last) {
        pooled_before[row] += finding.weighed.before[row] * finding.weighed.before[row];
        pooled_after[row] += after[row] * after[row];
        square_before += finding.weighed.before[row] * finding.weighed.before[row];
        square_after += after[row] * after[row];
        count += 1.0;
      }
    }
    d.heldout_rms_before_um = std::sqrt(square_before / std::max(count, 1.0));
    d.heldout_rms_after_um = std::sqrt(square_after / std::max(count, 1.0));
    d.reduction_percent = reduction_percent(d.heldout_rms_before_um, d.heldout_rms_after_um);
    const Interval ci = reduction_interval(pooled_before(segments_.last), pooled_after(segments_.last),
                                           static_cast<Index>(std::lround(2.0 * hour / record_.interval)));
    d.ci95_low_percent = ci.low;
    d.ci95_high_percent = ci.high;
  }

  void add_verdict(Diagnosis& d) const {
    const auto all = [&](auto holds) { return std::all_of(findings_.begin(), findings_.end(), holds); };
    const auto off = [](const ChannelFinding& f) { return !f.clean() && !f.open() && !f.names(); };
    const bool unexplained = !all([&](const ChannelFinding& f) { return !off(f); });
    const bool all_shared =
        all([&](const ChannelFinding& f) { return !off(f) || (!f.holding.empty() && f.weighed.unknown < 0.5); });
    const std::vector<RankedCause> rivals = rivals_of();
    const std::vector<std::string> untold = channels([](const ChannelFinding&f) { return f.open() && f.untold; }),
                                   open = channels([](const ChannelFinding&f) { return f.open(); });
    if (!untold.empty()) d.next = needed(record_, segments_, widest_untold());
    if (all([](const ChannelFinding& f) { return f.clean(); })) {
      d.verdict = Verdict::no_discrepancy;
      d.sentence = fmt::format("No discrepancy: the record follows the lag model of its first {:.0f} h {}.",
                               fitted_hours(), how_well([](const ChannelFinding&) { return true; }, 1));
    } else if (unexplained && !all_shared) {
      d.verdict = Verdict::unexplained;
      d.sentence = unexplained_sentence(d);
    } else if (unexplained) {
      d.verdict = Verdict::ambiguous;
      d.sentence = fmt::format(
          "Ambiguous: the lag model of the first {:.0f} h does not predict the later data; {} or an unknown cause "
          "explains the difference.{}",
          fitted_hours(), core::join(names_of(rivals)), beside(d));
    } else if (!untold.empty()) {
      d.verdict = Verdict::ambiguous;
      const ChannelFinding& widest = widest_untold();
      d.sentence = fmt::format(
          "Ambiguous: this record does not show whether {} changed after its first {:.0f} h. {}.{} To decide, "
          "measure {} under {}: {}.",
          core::join(untold), fitted_hours(), how_widely_predicted(widest), beside(d), d.next.channel, d.next.load,
          d.next.why);
    } else if (!open.empty()) {
      d.verdict = Verdict::ambiguous;
      const std::string well = how_well([](const ChannelFinding& f) { return f.open(); }, open.size());
      d.sentence = "Ambiguous: " + doubt(open, fitted_hours(), well, names_of(rivals)) + beside(d);
    } else {
      d.verdict = Verdict::explained;
      d.sentence = fmt::format(
          "Explained by {}: in the last part, which is held out, the RMS of the displacements goes from {:.2f} to "
          "{:.2f} um.",
          core::join(names_of(d.causes)), d.heldout_rms_before_um, d.heldout_rms_after_um);
    }
    if (d.verdict == Verdict::ambiguous) add_ambiguous_set(rivals, unexplained, d);
  }

private:
  static std::string how_widely_predicted(const ChannelFinding& f) {
    if (f.weighed.expected > tells_nothing * f.signal)
      return fmt::format("Its first part does not predict {}, which varies by {:.3g} {} later", f.channel, f.signal,
                         f.unit);
    return fmt::format("{} is predicted within +- {:.3g} {} and varies by {:.3g} {} (one standard deviation each)",
                       f.channel, f.weighed.expected, f.unit, f.signal, f.unit);
  }
  double fitted_hours() const { return (segments_.first_end - record_.time[0]) / hour; }

  static std::vector<std::string> names_of(const std::vector<RankedCause>& causes) {
    std::vector<std::string> named;
    for (const RankedCause& cause : causes) named.push_back(name_of(cause.parameter));
    return named;
  }
  template <class Holds>
  std::vector<std::string> channels(const Holds& holds) const {
    std::vector<std::string> names;
    for (const ChannelFinding& finding : findings_)
      if (holds(finding)) names.push_back(finding.channel);
    return names;
  }
  static std::string beside(const Diagnosis& d) { return explain_the_rest(names_of(d.causes)); }

  /// Of the channels that the sentence is about: within their uncertainty, or how far a residual exceeds it by chance.
  /// @param subjects  of the sentence
  template <class About>
  std::string how_well(const About& about, std::size_t subjects) const {
    const ChannelFinding* worst = nullptr;
    for (const ChannelFinding& finding : findings_)
      if (about(finding) && (worst == nullptr || finding.strays() > worst->strays())) worst = &finding;
    if (worst == nullptr || worst->strays() <= worth_saying) return within_uncertainty(subjects);
    return fmt::format("with a residual of {} that is {:.2g} times the expected one (p = {:.2g})", worst->channel,
                       worst->strays(), worst->weighed.p_value);
  }

  /// Causes that hold in the last part without being sure.
  std::vector<RankedCause> rivals_of() const {
    std::vector<RankedCause> rivals;
    for (const ChannelFinding& finding : findings_) {
      if (finding.clean() || finding.names() || (finding.untold && !finding.discrepancy)) continue;
      for (const std::size_t i : finding.holding) rivals.push_back(cause_of(finding, i));
    }
    return rivals;
  }

  const ChannelFinding& widest_untold() const {
    const ChannelFinding* widest = nullptr;
    const auto width = [](const ChannelFinding& f) { return f.weighed.expected / std::max(f.signal, 1e-12); };
    for (const ChannelFinding& finding : findings_)
      if (finding.open() && finding.untold && (widest == nullptr || width(finding) > width(*widest))) widest = &finding;
    return *widest;
  }

  std::string unexplained_sentence(const Diagnosis& d) const {
    std::string sentence = fmt::format(
        "Unexplained: the lag model of the first {:.0f} h does not predict the later data, and {}. Section \"How it "
        "was "
        "judged\" of report.html describes the residual.",
        fitted_hours(), hold_in_the_last_part(names_of(d.causes)));
    for (const ChannelFinding& finding : findings_) {
      if (finding.refused()) {
        sentence += fmt::format(
            " {} of {} has a probability of {:.2f} before the last part and does not hold there (gain {} %, 95 % "
            "interval {} to {}).",
            name_of(finding.leading().kind), finding.channel, finding.leading().probability,
            percent_text(finding.last_part[finding.best].explained_percent),
            percent_text(finding.last_part[finding.best].gain.low),
            percent_text(finding.last_part[finding.best].gain.high));
      }
    }
    return sentence;
  }

  void add_notes(const ChannelFinding& finding, Diagnosis& d) const {
    for (const std::string& note : notes_of(record_, finding)) d.notes.push_back(note);
    if (!finding.open()) return;
    if (finding.untold) {
      d.notes.push_back(
          fmt::format("{}: its expected standard deviation after the first part, {:.3g} {}, exceeds half of its "
                      "variation, {:.3g} {}; a discrepancy would not show.",
                      finding.channel, finding.weighed.expected, finding.unit, finding.signal, finding.unit));
    } else {
      d.notes.push_back(fmt::format(
          "{}: the later data lie within their expected spread, but the probability of no change is only {:.2f}.",
          finding.channel, finding.none()));
    }
  }

  ChannelResidual residual_of(const ChannelFinding& finding) const {
    const compensation::MeasuredChannel& channel = record_.channels[finding.target];
    const std::vector<Index> first = finite_rows(record_.targets.col(finding.target), segments_.first);
    ChannelResidual residual;
    residual.id = channel.id;
    residual.unit = channel.unit;
    residual.uncertainty = channel.uncertainty;
    residual.rms_before = finding.rms_before;
    residual.rms_after = root_mean_square(finding.after(record_)(finding.last));
    residual.explained_std = root_mean_square(finding.weighed.expected_std(finding.last));
    residual.p_value_white = white_noise_p_value(finding.weighed.before(first));
    return residual;
  }

  /// The set of a channel that is open or off: none where it is not refused, the rivals, unknown.
  void add_ambiguous_set(const std::vector<RankedCause>& rivals, bool unexplained, Diagnosis& d) const {
    const auto least = [&](auto of) {
      double value = 1.0;
      for (const ChannelFinding& finding : findings_)
        if (!finding.clean() && !finding.names()) value = std::min(value, of(finding));
      return value;
    };
    const double none = least([](const ChannelFinding& f) { return f.none(); });
    const double unknown = 1.0 - least([](const ChannelFinding& f) { return 1.0 - f.unknown(); });
    if (!unexplained) d.ambiguous_set.push_back(no_cause(Kind::none, "", none));
    d.ambiguous_set.insert(d.ambiguous_set.end(), rivals.begin(), rivals.end());
    d.ambiguous_set.push_back(no_cause(Kind::unknown, "", unknown));
  }

  const DataRecord& record_;
  const RecordSegments& segments_;
  std::vector<ChannelFinding> findings_;
};

}  // namespace

Diagnosis diagnose_data(const compensation::Measurement& measurement, const DiagnoseOptions& options) {
  options.validate();
  const DataRecord data = data_record(measurement, options.interval_s);
  const RecordSegments segments = divide(data);
  refuse_empty_segments(data, segments, measurement.folder.string());
  Diagnosis d;
  d.measurement = measurement.folder.filename().string();
  d.heldout_from_s = segments.last_start;
  const Record record(data, segments);
  record.add_channels(d);
  record.add_series(d);
  record.add_gain(d);
  record.add_verdict(d);
  return d;
}

}  // namespace thermotwin::diagnosis
