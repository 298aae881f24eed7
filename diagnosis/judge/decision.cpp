// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/decision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "core/text.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/judgement.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double none_left = 1.0 - sure;  ///< for none; with less a cause may be named
/// Sizes that wander by 15 %, and others at 2.5 stated deviations, asked for 1.7 and 3.1 at most; laws of another kind
/// for 2.4 to 6 and 4 to 4.4.
constexpr double most_freedom = 2.5, most_other = 3.5;
constexpr double most_times_expected = 3.0;  ///< RMS of a channel without a cause where there is no discrepancy
constexpr double certain = 2.0;              ///< of its own standard deviations that a size has to be off
constexpr double near_bound = 0.01;          ///< of a bound, that an estimate is at it
constexpr double within_nominal = 3.0;       ///< stated standard deviations that are no discrepancy
constexpr double likely =
    0.5;  ///< a second cause is named where the model with it is more likely than all without, and which one is sure
constexpr double set_holds = 0.95, least_in_set = 0.01;  ///< of what is not named, and of each that is listed for it

constexpr std::size_t most_explanations = 8;
constexpr double least_shown = 0.02;

/// Two digits of the standard deviation are what an estimate is worth.
double rounded(double value, double std) {
  if (!(std > 0.0) || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std)) - 1.0);
  return std::stod(fmt::format("{:.9g}", std::round(value / unit) * unit));
}

RankedCause ranked(const Problem& problem, const SearchResult& found, int parameter) {
  RankedCause cause;
  cause.parameter = problem.parameters[parameter];
  cause.probability = found.marginal[parameter];
  const Hypothesis& single = *found.single(parameter);
  cause.log_evidence = single.log_evidence;
  // The estimate is that of the best model that holds the cause.
  for (const Hypothesis& h : found.hypotheses) {
    const auto at = std::find(h.members.begin(), h.members.end(), parameter);
    if (at == h.members.end()) continue;
    const Index k = at - h.members.begin();
    // Where something unknown acts, an estimate is wrong by more than its own deviation.
    const double widened = h.std[k] * std::sqrt(1.0 + found.probability_unknown * found.misfit);
    cause.std = std::max(h.std[k], std::min(widened, cause.parameter.cause_std));
    cause.value = rounded(h.value[k], cause.std);
    break;
  }
  const VectorXd predicted = single.refined
                                 ? single.predicted
                                 : VectorXd(problem.predicted + problem.columns.col(parameter) *
                                                                    (single.value[0] - problem.nominal[parameter]));
  cause.heldout_explained_percent = heldout_explained_percent(problem, predicted);
  return cause;
}

RankedCause no_parameter(Kind kind, double probability, double log_evidence) {
  RankedCause cause;
  cause.parameter.kind = kind;
  cause.parameter.name.clear();
  cause.parameter.unit.clear();
  cause.probability = probability;
  cause.log_evidence = log_evidence;
  return cause;
}

RankedCause something_unknown(const SearchResult& found) {
  return no_parameter(Kind::unknown, found.probability_unknown, found.log_evidence_unknown);
}

RankedCause other_law(const Problem& problem, const ChangingLaw& law) {
  RankedCause cause = no_parameter(Kind::other_law, law.probability, law.log_evidence);
  cause.parameter.where = problem.parameters[law.parameter].where;
  return cause;
}

/// A cause that is sure beside something unknown, and strong without it, is named with the rest left open. What is
/// wrong with one reading can as well be a part of something unknown in it: it has to say more than that alone.
bool named_beside_unknown(const RankedCause& cause, const SearchResult& found) {
  const double needed = acts_on_readings(cause.parameter.kind) ? std::max(strong, found.log_evidence_unknown) : strong;
  return found.probability_leftover >= 0.5 && cause.probability >= sure && found.log_evidence_beside >= needed;
}

/// Those that share what the named ones leave, something unknown among them.
/// @param causes  in order of probability
std::vector<RankedCause> sharing(const std::vector<RankedCause>& causes, const SearchResult& found) {
  std::vector<RankedCause> left, set;
  for (const RankedCause& cause : causes)
    if (cause.probability < sure) left.push_back(cause);
  const RankedCause unknown = something_unknown(found);
  left.insert(std::find_if(left.begin(), left.end(),
                           [&](const RankedCause& cause) { return cause.probability < unknown.probability; }),
              unknown);
  double all = 0.0, sum = 0.0;
  for (const RankedCause& cause : left) all += cause.probability;
  for (const RankedCause& cause : left) {
    if (!set.empty() && (sum >= set_holds * all || cause.probability < least_in_set)) break;
    sum += cause.probability;
    set.push_back(cause);
  }
  return set;
}

/// Of two that are sure the stronger one leads: the other may be no more than an uncertain value seen better beside it.
void sort_by_lead(std::vector<RankedCause>& causes) {
  std::stable_sort(causes.begin(), causes.end(), [](const RankedCause& a, const RankedCause& b) {
    return a.probability >= sure && b.probability >= sure ? a.log_evidence > b.log_evidence
                                                          : a.probability > b.probability;
  });
}

/// Those that matter by name. What is less likely is summed: with the first one in it, and without.
std::vector<Explanation> explanations_of(const Problem& problem, const SearchResult& found) {
  struct Candidate {
    Explanation shown;
    const std::vector<int>* members;  ///< nullptr: something unknown
  };
  std::vector<Candidate> all;
  for (const Hypothesis& h : found.hypotheses) {
    std::vector<std::string> names;
    for (const int member : h.members) {
      const Parameter& p = problem.parameters[member];
      names.push_back(name_of(p) + (p.missing ? " following " + p.missing->follows : ""));
    }
    all.push_back({{names.empty() ? "no cause: the machine as stated" : core::join(names, " and "), h.probability,
                    h.log_evidence},
                   &h.members});
  }
  for (const ChangingLaw& law : found.laws) {
    all.push_back({{name_of(Kind::other_law) + " of " + problem.parameters[law.parameter].where, law.probability,
                    law.log_evidence},
                   nullptr});
  }
  all.push_back(
      {{"something unknown, alone or beside a cause", found.probability_unknown, found.log_evidence_unknown}, nullptr});
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& a, const Candidate& b) { return a.shown.probability > b.shown.probability; });
  const Candidate first = all.front();
  const auto holds_first = [&](const Candidate& other) {
    return first.members != nullptr && !first.members->empty() && other.members != nullptr &&
           std::all_of(first.members->begin(), first.members->end(), [&](int member) {
             return std::find(other.members->begin(), other.members->end(), member) != other.members->end();
           });
  };
  std::vector<Explanation> shown;
  double with_first = 0.0, rest = 0.0;
  for (const Candidate& one : all) {
    if (shown.size() < most_explanations && (shown.empty() || one.shown.probability >= least_shown))
      shown.push_back(one.shown);
    else
      (holds_first(one) ? with_first : rest) += one.shown.probability;
  }
  if (with_first >= 0.0005)
    shown.push_back({first.shown.name + " with a second cause, each of them unlikely", with_first, {}});
  if (rest >= 0.0005) shown.push_back({"all others together", rest, {}});
  return shown;
}

/// Fills the ranking of what the record can show, none and unknown. @return causes, the leading one first
std::vector<RankedCause> rank(const Problem& problem, const SearchResult& found, Diagnosis& out) {
  const std::set<int> hidden(found.invisible.begin(), found.invisible.end());
  for (int i = 0; i < std::ssize(problem.parameters); ++i)
    if (!hidden.count(i)) out.ranking.push_back(ranked(problem, found, i));
  std::vector<RankedCause> causes = out.ranking;
  out.ranking.push_back(no_parameter(Kind::none, found.probability_none, 0.0));
  out.ranking.push_back(something_unknown(found));
  for (const ChangingLaw& law : found.laws)
    if (law.probability >= least_in_set) out.ranking.push_back(other_law(problem, law));
  out.explanations = explanations_of(problem, found);
  sort_by_lead(out.ranking);
  sort_by_lead(causes);
  return causes;
}

/// The leading cause is sure and strong, but within its stated uncertainty: it and something unknown.
void name_more_than_stated(const std::vector<RankedCause>& causes, const SearchResult& found, Diagnosis& out) {
  out.verdict = Verdict::ambiguous;
  out.causes.push_back(causes.front());
  for (auto cause = std::next(causes.begin()); cause != causes.end(); ++cause)
    if (cause->probability >= sure && outside_nominal(*cause)) out.causes.push_back(*cause);
  out.ambiguous_set.push_back(something_unknown(found));
}

/// Something unknown is likely: alone, beside causes that are sure, or shared with one.
void decide_beside_unknown(const std::vector<RankedCause>& causes, const SearchResult& found, Diagnosis& out) {
  out.verdict = Verdict::unexplained;
  if (causes.empty() || !outside_nominal(causes.front())) return;
  const double leading = causes.front().probability;
  if (named_beside_unknown(causes.front(), found)) {
    out.verdict = Verdict::ambiguous;
    for (const RankedCause& cause : causes) {
      if (outside_nominal(cause) && cause.probability >= likely)
        (cause.probability >= sure ? out.causes : out.ambiguous_set).push_back(cause);
    }
    out.ambiguous_set.push_back(something_unknown(found));
  } else if (found.probability_unknown - found.probability_leftover < set_holds && leading >= 1.0 - set_holds &&
             leading < sure) {
    out.verdict = Verdict::ambiguous;
    out.ambiguous_set = sharing(causes, found);
  }
}

/// The machine as stated fits the fitted part already: chi-square as expected, no parameter far from what is stated of
/// it, and no channel further off than expected. A cause may fit better still, but then the model's error is stated too
/// large to say so.
bool nothing_fits(const Problem& problem, const SearchResult& found) {
  if (found.fitted == 0 || found.chi_square_none > found.fitted || found.stretch.too_far()) return false;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted;
    const double off = (problem.measured - problem.predicted).segment(first, n).norm();
    if (off > problem.expected_std.segment(first, n).norm()) return false;
  }
  return true;
}

/// An estimate at the largest value that is looked for: what it stands for is more, or something else.
bool is_at_bound(const RankedCause& cause) {
  return cause.parameter.ratio && cause.value >= (1.0 - near_bound) * cause.parameter.high;
}

/// A film that transfers no heat at all: air and coolant always take some, so that it stands for something else. A
/// source or a flow may be off.
bool is_no_film(const RankedCause& cause) {
  constexpr double least_film = 0.03;
  return (cause.parameter.kind == Kind::film_coefficient || cause.parameter.kind == Kind::coolant_coupling) &&
         cause.value <= least_film;
}

/// One or two causes that are sure explain; else those that share do.
void decide_among(const Problem& problem, const std::vector<RankedCause>& causes, const SearchResult& found,
                  Diagnosis& out) {
  double second_needed = 0.0;
  for (const Hypothesis& h : found.hypotheses)
    if (h.members.size() == 2) second_needed += h.probability;
  std::size_t found_sure = 0;
  for (const RankedCause& cause : causes) {
    if (cause.probability < sure) break;
    ++found_sure;
    if (outside_nominal(cause)) out.causes.push_back(cause);
  }
  if (found_sure == 1 && !out.causes.empty() && causes.size() > 1 &&
      causes[1].probability >= std::max(likely, sure * second_needed) && outside_nominal(causes[1]) &&
      !is_at_bound(causes[1])) {
    out.causes.push_back(causes[1]);
    ++found_sure;
  }
  const bool complete = (found_sure >= 2 || (found_sure == 1 && second_needed < sure)) && !nothing_fits(problem, found);
  out.verdict = complete && !out.causes.empty() ? Verdict::explained : Verdict::ambiguous;
  if (out.verdict == Verdict::explained) return;
  if (nothing_fits(problem, found) && !out.causes.empty()) {
    out.ambiguous_set = std::move(out.causes);
    out.causes.clear();
    out.ambiguous_set.push_back(no_parameter(Kind::none, found.probability_none, 0.0));
    out.open_because = fmt::format(
        "the machine as stated already fits: chi-square {:.0f} for {} values, and no channel is further off than "
        "expected",
        found.chi_square_none, found.fitted);
  } else {
    out.ambiguous_set = sharing(causes, found);
  }
}

/// Sources and joints one of which changes in the course of the record, and something unknown.
void share_among_laws(const Problem& problem, const SearchResult& found, Diagnosis& out) {
  out.verdict = Verdict::ambiguous;
  double all = 0.0, sum = 0.0;
  for (const ChangingLaw& law : found.laws) all += law.probability;
  for (const ChangingLaw& law : found.laws) {
    if (sum >= set_holds * all) break;
    sum += law.probability;
    out.ambiguous_set.push_back(other_law(problem, law));
  }
  out.ambiguous_set.push_back(something_unknown(found));
}

/// The channel whose fitted part is furthest from the prediction, in what is expected of it.
std::pair<std::size_t, double> furthest_channel(const Problem& problem) {
  std::pair<std::size_t, double> furthest{0, 0.0};
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted;
    const double expected = problem.expected_std.segment(first, n).norm();
    const double off = (problem.measured - problem.predicted).segment(first, n).norm();
    if (expected > 0.0 && off > furthest.second * expected) furthest = {k, off / expected};
  }
  return furthest;
}

/// Whether the cause brings the channel that is furthest off clearly nearer to its prediction.
bool lessens_furthest(const Problem& problem, const RankedCause& cause) {
  constexpr double clearly = 0.8;
  if (problem.observations.channels.empty()) return false;
  const std::size_t k = furthest_channel(problem).first;
  const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted;
  const VectorXd off = (problem.measured - problem.predicted).segment(first, n);
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    const Parameter& p = problem.parameters[i];
    if (p.kind != cause.parameter.kind || p.where != cause.parameter.where) continue;
    const VectorXd change = (cause.value - problem.nominal[i]) * problem.columns.col(i).segment(first, n);
    if ((off - change).norm() < clearly * off.norm()) return true;
  }
  return false;
}

/// Why the machine as stated does not fit, though no cause is more likely; empty: it fits.
std::string why_none_does_not_fit(const Problem& problem, const SearchResult& found) {
  const Stretch& stretch = found.stretch;
  if (stretch.beyond()) {
    return fmt::format("without a cause, {} would have to deviate by {:.1f} stated standard deviations",
                       name_of(problem.parameters[stretch.which]), std::abs(stretch.deviations));
  }
  if (stretch.too_far()) {
    return fmt::format(
        "without a cause, the parameters together would have to deviate more than stated (sum of squares {:.0f}, "
        "expected {:.0f})",
        stretch.squares, stretch.squares_mean);
  }
  const auto [channel, times] = furthest_channel(problem);
  if (times <= most_times_expected) return "";
  return fmt::format("without a cause, {} is {:.1f} times as far off as expected",
                     problem.observations.channels[channel].channel.id, times);
}

/// None is likely enough to stay, and so is a cause: the record does not tell which.
void share_with_none(const Problem& problem, const RankedCause& cause, const SearchResult& found, Diagnosis& out) {
  out.verdict = Verdict::ambiguous;
  out.ambiguous_set = {cause, no_parameter(Kind::none, found.probability_none, 0.0)};
  out.open_because = why_none_does_not_fit(problem, found);
}

/// No cause is likelier than none, but none does not fit as it is stated: it shares with what is furthest off, or with
/// something unknown.
/// @return whether it is so
bool share_with_stretched(const Problem& problem, const std::vector<RankedCause>& causes, const SearchResult& found,
                          Diagnosis& out) {
  if (!(found.probability_none > none_left) || why_none_does_not_fit(problem, found).empty()) return false;
  RankedCause sharing = something_unknown(found);
  if (const int which = found.stretch.which; found.stretch.too_far() && which >= 0) {
    const Parameter& stretched = problem.parameters[which];
    for (const RankedCause& cause : causes)
      if (cause.parameter.kind == stretched.kind && cause.parameter.where == stretched.where) sharing = cause;
  } else if (!causes.empty() && outside_nominal(causes.front()) && lessens_furthest(problem, causes.front())) {
    sharing = causes.front();
  }
  if (sharing.parameter.kind == Kind::unknown && !found.stretch.too_far() && !problem.observations.channels.empty())
    out.unknown_in = {problem.observations.channels[furthest_channel(problem).first].channel.id};
  share_with_none(problem, sharing, found, out);
  return true;
}

}  // namespace

bool outside_nominal(const RankedCause& cause) {
  // No source that machine.toml does not have is stated, and how large one is depends on where: that it is seen counts.
  if (cause.parameter.missing && cause.log_evidence >= strong) return true;
  const double off = std::abs(cause.value - cause.parameter.nominal);
  return off > within_nominal * cause.parameter.nominal_std && off > certain * cause.std;
}

void decide(const Problem& problem, const SearchResult& found, Diagnosis& out) {
  const std::vector<RankedCause> causes = rank(problem, found, out);
  const bool no_cause_left = causes.empty() || !outside_nominal(causes.front());
  // Sure and strong, though no further off than stated: its uncertainty alone would have been enough for none, so it is
  // more than that.
  const bool more_than_stated =
      !causes.empty() && causes.front().probability >= sure && causes.front().log_evidence >= strong;
  const bool unknown_likely = found.probability_unknown >= 0.5;
  double laws = 0.0;
  for (const ChangingLaw& law : found.laws) laws += law.probability;
  if (found.probability_none <= none_left && laws >= likely)
    share_among_laws(problem, found, out);
  else if (found.probability_none > none_left && !no_cause_left && causes.front().probability >= likely)
    share_with_none(problem, causes.front(), found, out);
  else if (found.probability_none > none_left && unknown_likely)
    share_with_none(problem, something_unknown(found), found, out);
  else if (found.probability_none > none_left || (no_cause_left && !unknown_likely && !more_than_stated))
    out.verdict = share_with_stretched(problem, causes, found, out) ? Verdict::ambiguous : Verdict::no_discrepancy;
  else if (no_cause_left && !unknown_likely)
    name_more_than_stated(causes, found, out);
  else if (unknown_likely || causes.empty())
    decide_beside_unknown(causes, found, out);
  else
    decide_among(problem, causes, found, out);
}

namespace {

/// One source or joint whose size or distribution has to change in the course of the record: lubricant that thins, a
/// step in friction, preload that is lost.
void add_other_law(Diagnosis& out) {
  const RankedCause& leading = out.causes.front();
  const Target target = row_of(leading.parameter.kind).target;
  if (leading.parameter.missing || (target != Target::source && target != Target::joint)) return;
  RankedCause law = no_parameter(Kind::other_law, leading.probability, leading.log_evidence);
  law.parameter.where = leading.parameter.where;
  out.ambiguous_set.insert(out.ambiguous_set.begin(), std::move(law));
}

}  // namespace

void leave_open(const Problem& problem, const Strain& strain, Diagnosis& out) {
  if (out.verdict != Verdict::explained) return;
  const bool alone = out.causes.size() == 1;
  if (strain.freedom > most_freedom) {
    out.strained = fmt::format(
        "its size, heat distribution or lag would have to deviate {:.1f} times as far as expected", strain.freedom);
  } else if (strain.other > most_other) {
    const Parameter& other = problem.parameters[strain.which];
    out.strained = fmt::format("{} would have to deviate by {:.1f} stated standard deviations as well", name_of(other),
                               strain.other);
  }
  if (out.strained.empty()) return;
  leave_open(out.strained, out);
  if (alone && strain.freedom > most_freedom) add_other_law(out);
}

void leave_open(const std::string& reason, Diagnosis& out) {
  out.strained = reason;
  out.verdict = Verdict::ambiguous;
  // What two are strained to explain may be the stronger one and no second.
  std::stable_sort(out.causes.begin(), out.causes.end(),
                   [](const RankedCause& a, const RankedCause& b) { return a.log_evidence > b.log_evidence; });
  out.ambiguous_set.assign(std::next(out.causes.begin()), out.causes.end());
  RankedCause unknown = no_parameter(Kind::unknown, 0.0, 0.0);
  for (const RankedCause& cause : out.ranking)
    if (cause.parameter.kind == Kind::unknown) unknown = cause;
  out.ambiguous_set.push_back(unknown);
  out.causes.resize(1);
}

StepsSeen steps_seen(const Problem& problem, const SearchResult& found) {
  StepsSeen seen;
  if (found.probability_unknown < likely) return seen;
  const bool beside = found.probability_leftover > 0.5 * found.probability_unknown;
  const ReadingSteps& steps = beside ? found.beside_steps : found.unknown_steps;
  for (const std::size_t k : steps.channels) seen.channels.push_back(problem.observations.channels[k].channel.id);
  if (!seen.channels.empty()) {
    const ObservedChannel& first = problem.observations.channels[steps.channels.front()];
    seen.unit = first.channel.unit;
    seen.record = static_cast<std::size_t>(first.record);
  }
  seen.quantity = steps.quantity;
  if (!seen.quantity.empty()) {
    for (const std::size_t k : steps.channels) {
      const compensation::MeasuredChannel& channel = problem.observations.channels[k].channel;
      if (channel.quantity == seen.quantity) seen.unit = channel.unit;
    }
  }
  seen.steps = steps.steps;
  return seen;
}

std::vector<std::string> inputs_before(const Observations& observations, const mesh::Machine& machine,
                                       const StepsSeen& seen) {
  constexpr double before_s = 1800.0, after_s = 60.0, least_share = 0.05;
  constexpr std::size_t most = 4;
  const solver::Channels channels(machine);
  std::vector<std::string> states, others;
  const Observations& record = observations.each()[seen.record];
  for (Index c = 0; c < std::min<Index>(channels.size(), record.rows.cols()); ++c) {
    const std::string& name = channels.names()[c];
    const auto ends = [&](const char* end) { return name.ends_with(end); };
    const bool is_state = ends(".on") || ends(".open");
    if (!is_state && !ends("_rpm") && !ends("_min") && !ends(".power_W")) continue;
    const VectorXd values = record.rows.col(c);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    if (!(high > low)) continue;
    const auto near = [&](double time) {
      return std::any_of(seen.steps.begin(), seen.steps.end(), [&](const ReadingStep& step) {
        return time > step.from_s - before_s && time < step.from_s + after_s;
      });
    };
    bool found = false;
    for (Index i = 1; i < values.size() && !found; ++i)
      found = std::abs(values[i] - values[i - 1]) > least_share * (high - low) && near(record.points[i]);
    if (found) (is_state ? states : others).push_back(name);
  }
  states.insert(states.end(), others.begin(), others.end());
  if (states.size() > most) states.resize(most);
  return states;
}

void rank_anew(const Problem& problem, const SearchResult& found, Diagnosis& out) {
  out.ranking.clear();
  rank(problem, found, out);
}

std::string uncertain_size(const Diagnosis& d) {
  for (const RankedCause& cause : d.causes) {
    const double off = cause.value - cause.parameter.nominal;
    if (std::abs(off) > certain * cause.std) continue;
    const std::string unit = cause.parameter.unit == "1" ? "" : " " + cause.parameter.unit;
    return fmt::format("the {} of {} deviates by {}{} from nominal, less than two of its standard deviations of {}{}",
                       cause.parameter.name, name_of(cause.parameter), core::plain_number(off, 3), unit,
                       core::plain_number(cause.std, 2), unit);
  }
  return "";
}

std::string at_bound(const Diagnosis& d, const std::set<std::string>& switched) {
  for (const RankedCause& cause : d.causes) {
    const Parameter& p = cause.parameter;
    if (is_no_film(cause) && switched.count(p.where) == 0)
      return fmt::format("the {} of {} is almost 0, {:.2g}, and some heat always passes there", p.name, name_of(p),
                         cause.value);
    if (!is_at_bound(cause)) continue;
    return fmt::format("the {} of {} is the largest that is looked for, {:.3g}", p.name, name_of(p), p.high);
  }
  return "";
}

bool only_unknown_shares(const Diagnosis& d) {
  const auto nameless = [](const RankedCause& cause) {
    return cause.parameter.kind == Kind::unknown || cause.parameter.kind == Kind::other_law;
  };
  return d.verdict == Verdict::ambiguous && !d.ambiguous_set.empty() &&
         std::all_of(d.ambiguous_set.begin(), d.ambiguous_set.end(), nameless);
}

}  // namespace thermotwin::diagnosis
