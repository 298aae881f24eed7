// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/ranking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string>

#include "core/text.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/judgement.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double within_nominal = 3.0;  ///< stated standard deviations that are no discrepancy
constexpr double near_bound = 0.01;     ///< of a bound, that an estimate is at it
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

}  // namespace

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

void rank_anew(const Problem& problem, const SearchResult& found, Diagnosis& out) {
  out.ranking.clear();
  rank(problem, found, out);
}

bool outside_nominal(const RankedCause& cause) {
  // No source that machine.toml does not have is stated, and how large one is depends on where: that it is seen counts.
  if (cause.parameter.missing && cause.log_evidence >= strong) return true;
  const double off = std::abs(cause.value - cause.parameter.nominal);
  return off > within_nominal * cause.parameter.nominal_std && off > certain * cause.std;
}

bool is_at_bound(const RankedCause& cause) {
  return cause.parameter.ratio && cause.value >= (1.0 - near_bound) * cause.parameter.high;
}

}  // namespace thermotwin::diagnosis
