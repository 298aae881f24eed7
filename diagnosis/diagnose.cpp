// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "compensation/measurement/measurement_check.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/missing_source.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/changing_size.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/inference/missing_source_search.h"
#include "diagnosis/inference/model_search.h"
#include "diagnosis/inference/switch_times.h"
#include "diagnosis/judge/action.h"
#include "diagnosis/judge/connection_check.h"
#include "diagnosis/judge/decision.h"
#include "diagnosis/judge/detectability.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/judgement.h"
#include "diagnosis/judge/next_measurement.h"
#include "diagnosis/judge/place.h"
#include "diagnosis/judge/ranking.h"
#include "diagnosis/judge/reservations.h"
#include "diagnosis/judge/residual_analysis.h"
#include "diagnosis/judge/steps_seen.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/report/words.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"
#include "diagnosis/statistics/statistics.h"
#include "mesh/machine/file.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double none_gone = 0.003,
                 none_likely = 0.5;    ///< below the one and above the other, more of the record is not asked
constexpr double perhaps = 0.2;        ///< a cause beside those named that is worth more of the record
constexpr double still_heldout = 0.5;  ///< of what is held out, where the rest is fitted to decide
constexpr double clear = 200.0;        ///< ln Bayes factor against none that no second look changes
constexpr double most_moved = 3.0, least_moved = 0.1;  ///< stated deviations of other parameters in a second look
constexpr double within_expected = 1.5;                ///< RMS of a residual over what is expected of it

/// The causes that the 'after' columns show: the named ones, else the members of the best model.
Hypothesis shown(const Problem& problem, const SearchResult& found, const Diagnosis& d) {
  if (d.verdict == Verdict::no_discrepancy || d.verdict == Verdict::unexplained) return {};
  Hypothesis best;
  for (const Hypothesis& h : found.hypotheses) {
    if (!h.members.empty()) {
      best = h;
      break;
    }
  }
  if (d.verdict == Verdict::explained) {
    best = {};
    best.value.resize(std::ssize(d.causes));
    best.std.resize(best.value.size());
    for (std::size_t k = 0; k < d.causes.size(); ++k) {
      for (int i = 0; i < std::ssize(problem.parameters); ++i) {
        if (problem.parameters[i].kind == d.causes[k].parameter.kind &&
            problem.parameters[i].where == d.causes[k].parameter.where &&
            problem.parameters[i].missing == d.causes[k].parameter.missing)
          best.members.push_back(i);
      }
      best.value[k] = d.causes[k].value;
      best.std[k] = d.causes[k].std;
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

}  // namespace

std::vector<Parameter> marked_causes(const Diagnosis& diagnosis) {
  std::vector<Parameter> marked;
  constexpr double least_shown = 0.05;
  for (const RankedCause& cause : diagnosis.causes.empty() ? diagnosis.ambiguous_set : diagnosis.causes) {
    const bool shown = !diagnosis.causes.empty() || cause.probability >= least_shown;
    if (shown && !cause.parameter.name.empty()) marked.push_back(cause.parameter);
  }
  return marked;
}

namespace {

/// A measurement fitted up to a time: the problem, what the search found in it, and what is decided from that.
struct Look {
  Seen seen;
  SearchResult found;
  Diagnosis decided;
  Strain strain;  ///< of what is named
};

/// What the best hypothesis makes of all other parameters, as far as it is within three stated deviations; not of
/// readings, which are far from linear. (parameters that stand in machine.toml) less nominal
VectorXd other_parameters(const Problem& problem, const SearchResult& found) {
  const Hypothesis& best = found.hypotheses.front();
  const White white(problem);
  LinearForm form =
      best.members.empty() || !best.refined ? nominal_form(problem, white) : form_about(problem, white, best);
  for (std::size_t k = 0; k < form.members.size(); ++k)
    form.prior_std[form.members[k]] = cause_std_at(problem.parameters[form.members[k]], form.value[k]);
  const VectorXd mean = LinearEvidence(form.columns, form.residual, form.prior_std).mean();
  VectorXd around = VectorXd::Zero(problem.around.size());
  for (Index i = 0; i < around.size(); ++i) {
    const Parameter& p = problem.parameters[i];
    if (acts_on_readings(p.kind) || std::find(form.members.begin(), form.members.end(), i) != form.members.end())
      continue;
    const double std = problem.prior_std[i], shift = std::clamp(mean[i], -most_moved * std, most_moved * std);
    if (std::abs(shift) > least_moved * std)
      around[i] = std::clamp(p.nominal + shift, p.low + (p.ratio ? 0.02 : 0.0), p.high) - p.nominal;
  }
  return around;
}

/// A verdict that is not clear may rest on what several parameters, each within its uncertainty, do together.
bool deserves_second_look(const SearchResult& found) {
  return found.probability_none < none_likely && found.hypotheses.front().log_evidence < clear;
}

/// How far what is named strains the whole record, and what held-out data say of it where something unknown acts too.
void judge_explanation(const Problem& problem, const Response& response, const mesh::Machine& machine, Look& look) {
  Hypothesis named = shown(problem, look.found, look.decided);
  if (named.members.empty()) return;
  linearise(named, problem, response, machine);
  if (!look.decided.causes.empty()) look.strain = strain_of(problem, named);
  if (look.found.probability_unknown < 0.5) return leave_open(problem, look.strain, look.decided);
  raise_misfit(look.found, heldout_misfit(problem, named, look.found.beside_channels));
  look.decided = {};
  decide(problem, look.found, look.decided);
}

Look look_at(const reduction::ReducedModel& model, Records records, const DiagnoseOptions& options) {
  const mesh::Machine& machine = model.machine;
  Look look{.seen = see(model, records, options), .found = {}, .decided = {}, .strain = {}};
  Problem& problem = look.seen.problem;
  const Response& response = *look.seen.response;
  const VectorXd nominal_prediction = problem.predicted;
  const auto search_it = [&] {
    add_missing_sources(problem, response, model, records);
    look.found = search(problem, response, machine);
  };
  search_it();
  if (deserves_second_look(look.found)) {
    problem = make_problem(machine, records, *look.seen.observations, response, options,
                           other_parameters(problem, look.found));
    search_it();
  }
  if (records.size() == 1) {
    const ChangingSizes changing = find_changing_sizes(problem, response, machine, look.found);
    if (add_steps(problem, changing.steps, look.found)) look.found = search(problem, response, machine);
    add_laws(look.found, clear_laws(problem, look.found, changing.laws));
  }
  decide(problem, look.found, look.decided);
  judge_explanation(problem, response, machine, look);
  problem.predicted = nominal_prediction;  // what is judged is the machine as stated
  return look;
}

/// More of the record could decide it: neither a cause nor none is sure, causes share, or there may be one more.
bool is_open(const Look& look) {
  const double none = look.found.probability_none;
  const Diagnosis& d = look.decided;
  const bool one_more = std::any_of(d.ranking.begin(), d.ranking.end(), [](const RankedCause& cause) {
    return !cause.parameter.name.empty() && cause.probability > perhaps && cause.probability < sure;
  });
  return (none > none_gone && none < none_likely) ||
         (d.verdict == Verdict::ambiguous && d.strained.empty() && !only_unknown_shares(d)) ||
         (d.verdict == Verdict::explained && one_more);
}

/// Whether with this share there would be more to fit, and enough left to judge a gain: means of gauges, where there
/// are any.
bool leaves_enough(const Observations& seen, double heldout_share) {
  if (!seen.records.empty()) {
    return std::all_of(seen.records.begin(), seen.records.end(),
                       [&](const Observations& record) { return leaves_enough(record, heldout_share); });
  }
  const double split = split_between(seen, heldout_share);
  const bool gauged = std::any_of(seen.channels.begin(), seen.channels.end(),
                                  [](const ObservedChannel& c) { return !c.is_temperature(); });
  Eigen::Index most = 0;
  for (const ObservedChannel& channel : seen.channels)
    if (gauged != channel.is_temperature()) most = std::max<Index>(most, (channel.time.array() >= split).count());
  return split > seen.split && most >= least_means;
}

/// Of each record, or of the one.
template <class Values>
std::vector<std::string> of_each(Records records, const Values& values_of) {
  const std::vector<std::string> names = record_names(records);
  std::vector<std::string> all;
  for (std::size_t k = 0; k < records.size(); ++k)
    for (const std::string& value : values_of(k)) all.push_back(names[k].empty() ? value : names[k] + ": " + value);
  return all;
}

std::string names_of(Records records) {
  std::vector<std::string> names = record_names(records);
  if (records.size() == 1) names = {records.front().folder.filename().string()};
  return core::join(names, ", ");
}

std::string longer_note(const Observations& open, const Observations& seen) {
  return fmt::format(
      "The record until {:.2f} h left the cause open. It was therefore fitted until {:.2f} h, and later data were held "
      "out.",
      (open.split - open.start) / core::units::hour, (seen.split - seen.start) / core::units::hour);
}

/// What channels with another sign, unit or place read is explained by no cause.
void doubt_connections(const std::vector<ConnectionDoubt>& doubts, Diagnosis& d) {
  if (d.verdict == Verdict::no_discrepancy) return;
  std::vector<std::string> clauses;
  for (const ConnectionDoubt& one : doubts)
    if (one.strong) clauses.push_back(one.clause);
  d.connection = core::join(clauses, "; ");
  if (!clauses.empty() && d.verdict == Verdict::explained) leave_open(d.connection, d);
}

/// What speaks against an explanation leaves it open.
void doubt(const mesh::Machine& machine, Records records, const Observations& seen, const Strain& strain,
           Diagnosis& d) {
  const std::string worse = worsened(d);
  std::set<std::string> switched;
  for (const mesh::FilmSpec& film : machine.films)
    if (!film.state.empty()) switched.insert(film.id);
  std::vector<std::string> doubts{uncertain_size(d), at_bound(d, switched), worse};
  for (const compensation::Measurement& record : records) doubts.push_back(perhaps_unrecorded(machine, record, d));
  for (const Observations& record : seen.each()) doubts.push_back(perhaps_steady_heat(record, d));
  for (const std::string& one : doubts)
    if (d.verdict == Verdict::explained && !one.empty()) leave_open(one, d);
  leave_one_heat_open(machine, d);
  d.foretold_beside_others = !worse.empty() && d.strained == worse && strain.heldout_chi_square > 0.0 &&
                             strain.heldout_chi_square < not_foretold;
}

/// What was named on the fitted part does not hold on the rest: neither is it taken away from what is seen.
void withdraw(const Problem& problem, const Strain& strain, const std::string& objection, SearchResult& found,
              Hypothesis& best, Diagnosis& d) {
  const bool expected = std::all_of(d.residuals.begin(), d.residuals.end(), [](const ChannelResidual& r) {
    return r.rms_before <= within_expected * r.explained_std;
  });
  d.verdict =
      expected && found.hypotheses.front().log_evidence < strong ? Verdict::no_discrepancy : Verdict::unexplained;
  d.warnings.push_back(objection);
  d.causes.clear();
  d.ambiguous_set.clear();
  d.residuals.clear();
  raise_misfit(found, strain.heldout_misfit);
  rank_anew(problem, found, d);
  best = {};
  best.predicted = problem.predicted;
  best.refined = true;
  judge(problem, best, d);
}

/// Where to look and what to measure.
void advise(const Problem& problem, const SearchResult& found, const reduction::ReducedModel& model,
            const DiagnoseOptions& options, Diagnosis& d) {
  d.steps = steps_seen(problem, found);
  d.steps.inputs = inputs_before(problem.observations, model.machine, d.steps);
  for (const std::size_t k : found.unknown_channels)
    d.unknown_in.push_back(problem.observations.channels[k].channel.id);
  d.analysis = analyse(problem, solver::Channels(model.machine));
  d.actions = actions_of(d, model);
  if (!d.connection.empty()) {
    d.actions = {fmt::format(
        "Check the connections first: {}. Correct channels.toml or the cables where it is so, and diagnose again.",
        d.connection)};
    d.next.why = "whether channels are what channels.toml states is seen at the machine, without a measurement";
  } else if (d.verdict != Verdict::no_discrepancy && d.extended_machine_text.empty()) {
    d.next = next_measurement(problem, model, options.programs, d, options);
  }
  d.detectable = detectability(problem, found);
  if (d.verdict == Verdict::no_discrepancy) d.next.why = nothing_to_decide(d.detectable);
}

Diagnosis diagnose_all(const reduction::ReducedModel& model, Records records, const DiagnoseOptions& options) {
  options.validate();
  const mesh::Machine& machine = model.machine;
  for (const compensation::Measurement& record : records) compensation::require_fits(record, machine);
  Look look = look_at(model, records, options);
  std::vector<Observations> open(look.seen.observations->each().begin(), look.seen.observations->each().end());
  DiagnoseOptions more = options;
  more.heldout_share = still_heldout * options.heldout_share;
  const bool longer = is_open(look) && leaves_enough(*look.seen.observations, more.heldout_share);
  // Nothing was judged yet: what the search sees now is not held out any more, the rest is.
  if (longer) look = look_at(model, records, more);
  const Response& response = *look.seen.response;
  const Problem& problem = look.seen.problem;
  SearchResult& found = look.found;

  Diagnosis d = std::move(look.decided);
  d.measurement = names_of(records);
  d.heldout_from_s = problem.observations.split;
  for (RankedCause& cause : d.causes) {
    const auto& missing = cause.parameter.missing;
    if (!missing) continue;
    cause.series = source_series(*missing, cause.value, cause.std, problem.observations, machine);
    cause.place = place_of(missing->body, missing->centre, model);
  }
  Hypothesis best = shown(problem, found, d);
  std::vector<Parameter> members;
  for (const int i : best.members) members.push_back(problem.parameters[i]);
  best.predicted =
      best.members.empty() ? problem.predicted : response.predict(with_parameters(machine, members, best.value));
  best.refined = true;
  judge(problem, best, d);
  if (const std::string objection = heldout_objection(d, look.strain.heldout_chi_square); !objection.empty())
    withdraw(problem, look.strain, objection, found, best, d);
  const std::vector<ConnectionDoubt> connections = connection_doubts(problem);
  doubt_connections(connections, d);
  doubt(machine, records, problem.observations, look.strain, d);
  if (d.verdict == Verdict::explained && worth_extending(problem, best, d))
    d.extended_machine_text = extend(machine, d.causes, d.measurement);
  advise(problem, found, model, options, d);
  const Observations& obs = problem.observations;
  const auto longer_notes = [&](std::size_t k) { return std::vector{longer_note(open[k], obs.each()[k])}; };
  if (longer)
    for (std::string& note : of_each(records, longer_notes)) d.notes.push_back(std::move(note));
  if (!d.causes.empty() && look.strain.heldout_chi_square > 0.0) {
    d.notes.push_back(
        fmt::format("The named causes predict held-out data with a chi-square of {:.2f} per value (1 or less: as "
                    "expected); all other parameters keep their fitted values.",
                    look.strain.heldout_chi_square));
  }
  for (std::string& warning :
       of_each(records, [&](std::size_t k) { return warnings_of(machine, records[k], obs.each()[k]); }))
    d.warnings.push_back(std::move(warning));
  add_notes(model, problem, found, options, d);
  for (std::string& words : in_words(d.analysis)) d.notes.push_back(std::move(words));
  if (std::string there = nearest_action(d); !there.empty()) d.actions.push_back(std::move(there));
  d.sentence = sentence_of(d);
  if (d.connection.empty() && !connections.empty())
    d.sentence += " Before anything else, check signs and units: the warnings name the channels.";
  for (auto one = connections.rbegin(); one != connections.rend(); ++one)
    d.warnings.insert(d.warnings.begin(), one->warning);
  return d;
}

}  // namespace

namespace {

/// A source that machine.toml does not have may follow the time of day, where a record tells it.
Diagnosis diagnose_by_hour(const reduction::ReducedModel& model, Records records, const DiagnoseOptions& options) {
  if (std::none_of(records.begin(), records.end(), compensation::tells_time_of_day))
    return diagnose_all(model, records, options);
  reduction::ReducedModel asking = model;
  asking.machine.asks_time_of_day = true;
  return diagnose_all(asking, records, options);
}

}  // namespace

Diagnosis diagnose(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
                   const DiagnoseOptions& options) {
  return diagnose_by_hour(model, Records(&measurement, 1), options);
}

Diagnosis diagnose(const reduction::ReducedModel& model, std::vector<compensation::Measurement> records,
                   const DiagnoseOptions& options) {
  return diagnose_by_hour(model, with_record_names(std::move(records)), options);
}

}  // namespace thermotwin::diagnosis
