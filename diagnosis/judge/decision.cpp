// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/decision.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/ranking.h"
#include "diagnosis/judge/stated_fit.h"

namespace thermotwin::diagnosis {

namespace {

constexpr double none_left = 1.0 - sure;  ///< for none; with less a cause may be named
constexpr double likely =
    0.5;  ///< a second cause is named where the model with it is more likely than all without, and which one is sure
constexpr double set_holds = 0.95;  ///< of what is not named

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

}  // namespace thermotwin::diagnosis
