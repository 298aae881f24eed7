// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/diagnose.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "core/error.h"
#include "core/text.h"
#include "diagnosis/judgement.h"
#include "diagnosis/missing_source.h"
#include "diagnosis/model_search.h"
#include "diagnosis/next_measurement.h"
#include "diagnosis/problem.h"
#include "diagnosis/residual_analysis.h"
#include "diagnosis/response.h"
#include "diagnosis/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double sure = 0.9;            ///< marginal probability that names a cause
/// A machine is called wrong only where it is as good as sure: with a tenth left, one of a hundred right ones was called wrong.
constexpr double none_left = 0.03;
constexpr double none_gone = 0.003, none_likely = 0.5;  ///< below the one and above the other, more of the record is not asked
constexpr double perhaps = 0.2;          ///< a cause beside those named that is worth more of the record
constexpr double still_heldout = 0.5;    ///< of what is held out, where the rest is fitted to decide
constexpr double within_expected = 1.5;  ///< RMS of a residual over what is expected of it
constexpr double strong = 10.0;          ///< ln Bayes factor against none
constexpr double within_nominal = 3.0;  ///< stated standard deviations that are no discrepancy

void require_valid(const DiagnoseOptions& options) {
  const auto require = [](bool holds, const std::string& name, double value, const std::string& allowed) {
    if (!holds) throw core::InputError("diagnose " + name, fmt::format("{}", value), allowed);
  };
  require(options.heldout_share >= 0.05 && options.heldout_share <= 0.9, "heldout_share",
          options.heldout_share, "0.05 to 0.9");
  for (const auto& [name, percent] : {std::pair{"displacement_error_percent", options.displacement_error_percent}, {"temperature_error_percent", options.temperature_error_percent}})
    require(percent > 0 && percent <= 50, name, percent, "above 0, at most 50");
  require(options.interval_s > 0, "interval_s", options.interval_s, "a positive number of seconds");
}

/// Two digits of the standard deviation are what an estimate is worth.
double rounded(double value, double std) {
  if (!(std > 0.0) || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std)) - 1.0);
  return std::stod(fmt::format("{:.9g}", std::round(value / unit) * unit));
}

RankedCause ranked(const Problem& problem, const SearchResult& found, int parameter) {
  RankedCause cause;
  cause.parameter = problem.parameters[static_cast<std::size_t>(parameter)];
  cause.probability = found.marginal[parameter];
  const Hypothesis& single = *found.single(parameter);
  cause.log_evidence = single.log_evidence;
  // The estimate is that of the best model that holds the cause.
  for (const Hypothesis& h : found.hypotheses) {
    const auto at = std::find(h.members.begin(), h.members.end(), parameter);
    if (at == h.members.end()) continue;
    const auto k = static_cast<Index>(at - h.members.begin());
    cause.std = h.std[k];
    cause.value = rounded(h.value[k], cause.std);
    break;
  }
  const VectorXd predicted =
      single.refined ? single.predicted
                     : VectorXd(problem.predicted + problem.columns.col(parameter) *
                                                        (single.value[0] - problem.nominal[parameter]));
  cause.heldout_explained_percent = heldout_explained_percent(problem, predicted);
  return cause;
}

RankedCause no_parameter(const std::string& kind, double probability, double log_evidence) {
  RankedCause cause;
  cause.parameter.kind = kind;
  cause.parameter.name.clear();
  cause.parameter.unit.clear();
  cause.probability = probability;
  cause.log_evidence = log_evidence;
  return cause;
}

bool outside_nominal(const RankedCause& cause) {
  return std::abs(cause.value - cause.parameter.nominal) > within_nominal * cause.parameter.nominal_std;
}

/// Ranking of all visible causes, none and unknown; verdict, named causes, those that share.
void decide(const Problem& problem, const SearchResult& found, Diagnosis& out) {
  std::set<int> hidden(found.invisible.begin(), found.invisible.end());
  for (int i = 0; i < static_cast<int>(problem.parameters.size()); ++i)
    if (!hidden.count(i)) out.ranking.push_back(ranked(problem, found, i));
  std::vector<RankedCause> causes = out.ranking;
  out.ranking.push_back(no_parameter("none", found.probability_none, 0.0));
  out.ranking.push_back(no_parameter("unknown", found.probability_unknown, found.log_evidence_unknown));
  const auto by_probability = [](const RankedCause& a, const RankedCause& b) {
    return a.probability > b.probability;
  };
  std::stable_sort(out.ranking.begin(), out.ranking.end(), by_probability);
  std::stable_sort(causes.begin(), causes.end(), by_probability);

  const bool no_cause_left = causes.empty() || !outside_nominal(causes.front());
  if (found.probability_none > none_left || (no_cause_left && found.probability_unknown < 0.5)) {
    out.verdict = "no_discrepancy";
    return;
  }
  if (found.probability_unknown >= 0.5 || causes.empty()) {
    out.verdict = "unexplained";
    // A cause that is sure beside something unknown, and strong without it, is named with the rest left open. What is wrong
    // with one reading can as well be a part of something unknown in it: it has to say more than that alone.
    if (found.probability_leftover < 0.5 || causes.empty() || causes.front().probability < sure || !outside_nominal(causes.front()) ||
        found.log_evidence_beside < (acts_on_readings(causes.front().parameter.kind) ? std::max(strong, found.log_evidence_unknown) : strong))
      return;
    out.verdict = "ambiguous";
    for (const RankedCause& cause : causes)
      if (cause.probability >= sure && outside_nominal(cause)) out.causes.push_back(cause);
    out.ambiguous_set.push_back(no_parameter("unknown", found.probability_unknown, found.log_evidence_unknown));
    return;
  }
  double second_needed = 0.0;
  for (const Hypothesis& h : found.hypotheses)
    if (h.members.size() == 2) second_needed += h.probability;
  for (const RankedCause& cause : causes)
    if (cause.probability >= sure && outside_nominal(cause)) out.causes.push_back(cause);
  const bool complete = out.causes.size() >= 2 || (out.causes.size() == 1 && second_needed < sure);
  if (complete) {
    out.verdict = "explained";
    return;
  }
  out.verdict = "ambiguous";
  double all = 0.0, sum = 0.0;
  for (const RankedCause& cause : causes) all += cause.probability;
  for (const RankedCause& cause : causes) {
    if (cause.probability >= sure) {
      all -= cause.probability;  // named already; the set is about the other one
      continue;
    }
    if (!out.ambiguous_set.empty() && (sum >= 0.95 * all || cause.probability < 0.01)) break;
    sum += cause.probability;
    out.ambiguous_set.push_back(cause);
  }
}

std::string in_words(const RankedCause& cause) {
  const Parameter& p = cause.parameter;
  const std::string unit = p.unit == "1" ? "" : " " + p.unit;
  const std::string more = p.missing ? fmt::format(", follows {}, 95 % within {:.0f} mm", p.missing->follows, 1e3 * p.missing->region95) : "";
  return fmt::format("{} of {} ({} {:.4g} +- {:.2g}{}{})", p.kind, p.where, p.name, cause.value, cause.std, unit, more);
}

std::string list_in_words(const std::vector<RankedCause>& causes, std::size_t most) {
  std::string words;
  for (std::size_t i = 0; i < std::min(most, causes.size()); ++i)
    words += (i > 0 ? "; " : "") + in_words(causes[i]) +
             fmt::format(", probability {:.2f}", causes[i].probability);
  if (causes.size() > most) words += fmt::format("; and {} more", causes.size() - most);
  return words;
}

/// What is named is sure, but it is not all.
bool only_unknown_shares(const Diagnosis& d) { return d.verdict == "ambiguous" && d.ambiguous_set.size() == 1 && d.ambiguous_set.front().parameter.name.empty(); }

std::string sentence_of(const Diagnosis& d) {
  const std::string gain = d.heldout_rms_before_um > 0
                               ? fmt::format(
                                     " On held-out time the displacements' RMS goes from {:.2f} to {:.2f} um "
                                     "({:.0f} %, 95 % interval {:.0f} to {:.0f}).",
                                     d.heldout_rms_before_um, d.heldout_rms_after_um, d.reduction_percent,
                                     d.ci95_low_percent, d.ci95_high_percent)
                               : "";
  if (d.verdict == "no_discrepancy")
    return "No discrepancy: measurement and model differ by no more than nominal uncertainty, mesh and noise "
           "explain.";
  if (d.verdict == "unexplained")
    return "Unexplained: measurement and model differ, but none of the known causes describes how.";
  if (only_unknown_shares(d))
    return fmt::format("Ambiguous: {}, and something beside it that no kind describes, probability {:.2f}.", list_in_words(d.causes, 2),
                       d.ambiguous_set.front().probability);
  if (d.verdict == "ambiguous")
    return (d.causes.empty() ? "Ambiguous: several causes explain the difference: "
                             : "Ambiguous: " + list_in_words(d.causes, 2) + " and one of: ") +
           list_in_words(d.ambiguous_set, 4) + ".";
  return "Explained by " + list_in_words(d.causes, 3) + "." + gain +
         (d.extended_machine_text.empty() ? " The gain is not certain, so no extension is recommended." : "");
}

/// The causes that the 'after' columns show: the named ones, else the members of the best model.
Hypothesis shown(const Problem& problem, const SearchResult& found, const Diagnosis& d) {
  if (d.verdict == "no_discrepancy" || d.verdict == "unexplained") return {};
  Hypothesis best;
  for (const Hypothesis& h : found.hypotheses)
    if (!h.members.empty()) {
      best = h;
      break;
    }
  if (d.verdict == "explained") {
    best = {};
    best.value.resize(static_cast<Index>(d.causes.size()));
    best.std.resize(best.value.size());
    for (std::size_t k = 0; k < d.causes.size(); ++k) {
      for (int i = 0; i < static_cast<int>(problem.parameters.size()); ++i)
        if (problem.parameters[static_cast<std::size_t>(i)].kind == d.causes[k].parameter.kind &&
            problem.parameters[static_cast<std::size_t>(i)].where == d.causes[k].parameter.where &&
            problem.parameters[static_cast<std::size_t>(i)].missing == d.causes[k].parameter.missing)
          best.members.push_back(i);
      best.value[static_cast<Index>(k)] = d.causes[k].value;
      best.std[static_cast<Index>(k)] = d.causes[k].std;
    }
  }
  return best;
}

std::string extend(const mesh::Machine& machine, const std::vector<RankedCause>& causes,
                   const std::string& measurement) {
  mesh::Machine extended = machine;
  for (const RankedCause& cause : causes) {
    const std::string text =
        extended_text(extended, cause.parameter, cause.value, cause.std,
                      fmt::format("measurement '{}', probability {:.2f}", measurement, cause.probability));
    extended = mesh::parse_machine(text, machine.path);
  }
  return extended.text;
}

/// Of the reduced model as the record begins, s.
double slowest_time_constant(const reduction::ReducedModel& model, const Observations& obs) {
  const solver::OperatingModel operating(model.machine, model.system.layout);
  const VectorXd p = operating.coefficients(obs.rows.row(0).transpose(), VectorXd::Zero(static_cast<Index>(model.machine.coolants.size()))).p;
  Eigen::MatrixXd a = model.system.conduction;
  for (Index j = 0; j < p.size(); ++j)
    if (p[j] != 0.0) a += p[j] * model.system.terms[static_cast<std::size_t>(j)];
  a = 0.5 * (a + a.transpose()).eval();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(a, model.system.capacity, Eigen::EigenvaluesOnly);
  return 1.0 / std::max(eigen.eigenvalues()[0], 1e-12);
}

void add_notes(const reduction::ReducedModel& model, const Problem& problem, const SearchResult& found, const DiagnoseOptions& options,
               Diagnosis& d) {
  const Observations& obs = problem.observations;
  if (const double slowest = slowest_time_constant(model, obs); obs.end - obs.start < slowest)
    d.notes.push_back(fmt::format("The record of {:.1f} h is shorter than the machine's slowest time constant of {:.1f} h: what acts that slowly "
                                  "is hardly seen, and the start counts for all of it.",
                                  (obs.end - obs.start) / 3600.0, slowest / 3600.0));
  if (!obs.left_out.empty())
    d.notes.push_back("Left out, with fewer than four values in the part that is fitted: " + core::join(obs.left_out) + ".");
  d.notes.push_back(fmt::format(
      "{} means over {:.0f} s of {} channels; {} of them were fitted (until {:.2f} h), the rest only judged.",
      obs.size(), obs.interval, obs.channels.size(), found.fitted, (obs.split - obs.start) / 3600.0));
  d.notes.push_back(
      fmt::format("Uniform start at {:.2f} degC (median of the first readings), uncertain by {:.2f} K.",
                  obs.start_C, problem.prior_std[static_cast<Index>(problem.parameters.size())]));
  d.notes.push_back(
      fmt::format("Mesh and discretisation: {:.3g} % of each displacement's own response, {:.3g} % of each temperature's. Chi-square without a "
                  "cause: {:.0f} for {} values.",
                  options.displacement_error_percent, options.temperature_error_percent, found.chi_square_none, found.fitted));
  if ((d.verdict == "unexplained" || only_unknown_shares(d)) && found.unknown_channel >= 0)
    d.notes.push_back("What no kind describes shows best in one channel alone: " +
                      obs.channels[static_cast<std::size_t>(found.unknown_channel)].channel.id + ".");
  if (!found.invisible.empty()) {
    std::vector<std::string> names;
    for (const int i : found.invisible)
      names.push_back(problem.parameters[static_cast<std::size_t>(i)].kind + " of " +
                      problem.parameters[static_cast<std::size_t>(i)].where);
    d.notes.push_back("Not visible in this measurement, so not judged: " + core::join(names) + ".");
  }
}

}  // namespace

std::vector<Parameter> marked_causes(const Diagnosis& diagnosis) {
  std::vector<Parameter> marked;
  for (const RankedCause& cause : diagnosis.causes.empty() ? diagnosis.ambiguous_set : diagnosis.causes) marked.push_back(cause.parameter);
  return marked;
}

namespace {

/// A measurement fitted up to a time: the problem, what the search found in it, and what is decided from that.
struct Look {
  std::unique_ptr<const Observations> observations;  ///< the response refers to it for its whole life
  std::unique_ptr<const Response> response;
  Problem problem;
  SearchResult found;
  Diagnosis decided;
};

Look look_at(const reduction::ReducedModel& model, const compensation::Measurement& measurement, const DiagnoseOptions& options) {
  const mesh::Machine& machine = model.machine;
  Look look;
  look.observations = std::make_unique<const Observations>(
      observe(measurement, machine, solver::Channels(machine), {.interval_s = options.interval_s, .heldout_share = options.heldout_share}));
  look.response = std::make_unique<const Response>(model, *look.observations);
  look.problem = make_problem(machine, measurement, *look.observations, *look.response, options);
  add_missing_sources(look.problem, *look.response, model, measurement);
  look.found = search(look.problem, *look.response, machine);
  decide(look.problem, look.found, look.decided);
  return look;
}

/// More of the record could decide it: neither a cause nor none is sure, causes share, or there may be one more.
bool is_open(const Look& look) {
  const double none = look.found.probability_none;
  const Diagnosis& d = look.decided;
  const bool one_more = std::any_of(d.ranking.begin(), d.ranking.end(), [](const RankedCause& cause) {
    return !cause.parameter.name.empty() && cause.probability > perhaps && cause.probability < sure;
  });
  return (none > none_gone && none < none_likely) || (d.verdict == "ambiguous" && !only_unknown_shares(d)) || (d.verdict == "explained" && one_more);
}

/// Whether with this share there would be more to fit, and enough left to judge a gain: means of gauges, where there are any.
bool leaves_enough(const Observations& seen, double heldout_share) {
  const double split = split_between(seen, heldout_share);
  const bool gauged = std::any_of(seen.channels.begin(), seen.channels.end(), [](const ObservedChannel& c) { return !c.is_temperature(); });
  Eigen::Index most = 0;
  for (const ObservedChannel& channel : seen.channels)
    if (gauged != channel.is_temperature()) most = std::max(most, static_cast<Eigen::Index>((channel.time.array() >= split).count()));
  return split > seen.split && most >= least_means;
}

}  // namespace

Diagnosis diagnose(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
                   const DiagnoseOptions& options) {
  require_valid(options);
  const mesh::Machine& machine = model.machine;
  compensation::require_fits(measurement, machine);
  Look look = look_at(model, measurement, options);
  const double open_until = look.observations->split;
  DiagnoseOptions more = options;
  more.heldout_share = still_heldout * options.heldout_share;
  const bool longer = is_open(look) && leaves_enough(*look.observations, more.heldout_share);
  // Nothing was judged yet: what the search sees now is not held out any more, the rest is.
  if (longer) look = look_at(model, measurement, more);
  const Response& response = *look.response;
  const Problem& problem = look.problem;
  const SearchResult& found = look.found;

  Diagnosis d = std::move(look.decided);
  d.measurement = measurement.folder.filename().string();
  d.heldout_from_s = problem.observations.split;
  for (RankedCause& cause : d.causes)
    if (const auto& missing = cause.parameter.missing) cause.series = source_series(*missing, cause.value, cause.std, problem.observations, machine);
  Hypothesis best = shown(problem, found, d);
  std::vector<Parameter> members;
  for (const int i : best.members) members.push_back(problem.parameters[static_cast<std::size_t>(i)]);
  best.predicted = best.members.empty() ? problem.predicted
                                        : response.predict(with_parameters(machine, members, best.value));
  best.refined = true;
  judge(problem, best, d);
  if (const std::string objection = heldout_objection(d); !objection.empty()) {
    // What was named on the fitted part does not hold: neither is it taken away from what is seen.
    const bool expected = std::all_of(d.residuals.begin(), d.residuals.end(), [](const ChannelResidual& r) { return r.rms_before <= within_expected * r.explained_std; });
    d.verdict = expected ? "no_discrepancy" : "unexplained";
    d.notes.push_back(objection);
    d.causes.clear();
    d.ambiguous_set.clear();
    d.residuals.clear();
    best = {};
    best.predicted = problem.predicted;
    best.refined = true;
    judge(problem, best, d);
  }
  if (d.verdict == "explained" && worth_extending(problem, best, d))
    d.extended_machine_text = extend(machine, d.causes, d.measurement);
  if (d.verdict == "ambiguous" && !only_unknown_shares(d)) d.next = next_measurement(problem, model, options.programs, d);
  d.analysis = analyse(problem, solver::Channels(machine));
  if (longer)
    d.notes.push_back(fmt::format("The record until {:.2f} h left the cause open: it was fitted until {:.2f} h, and what comes later was held out.",
                                  (open_until - problem.observations.start) / 3600.0, (problem.observations.split - problem.observations.start) / 3600.0));
  add_notes(model, problem, found, options, d);
  for (std::string& words : in_words(d.analysis)) d.notes.push_back(std::move(words));
  d.sentence = sentence_of(d);
  return d;
}

}  // namespace thermotwin::diagnosis
