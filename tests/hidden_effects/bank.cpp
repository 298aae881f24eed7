// SPDX-License-Identifier: GPL-3.0-or-later
#include "bank.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>
#include <tuple>

#include "baselines.h"
#include "core/error.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"
#include "refit.h"
#include "wrong_parts.h"

namespace thermotwin::hidden {

using diagnosis::Parameter;
using diagnosis::Kind;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr const char* group_names[] = {"single", "clean", "pair", "outside", "change"};

/// A wrong value: at least four of its standard deviations away, a share of what causes may be.
double drawn_value(const Parameter& p, Random& random) {
  const double least = 4.2 * p.nominal_std, most = std::max(1.3 * least, 1.2 * p.cause_std);
  double by = random.uniform(least, most);
  if (p.kind == Kind::sensor_lag) return random.uniform(900.0, 3600.0);
  if (p.kind == Kind::sensor_detached) return random.uniform(0.3, 0.95);
  if (p.kind == Kind::clock_shift) by = random.uniform(900.0, 5400.0);
  if (p.kind == Kind::sensor_offset) by = random.uniform(0.4, 2.0);
  const bool down = random.uniform() < 0.5;
  // What is multiplied falls as often as it rises, as far on a scale of logarithms.
  if (p.ratio) return down ? 1.0 / (1.0 + by) : 1.0 + by;
  const double value = down ? -by : by;
  return value < p.low ? by : value;
}

std::vector<Parameter> candidates(const Specimen& specimen, const std::string& load,
                                  const reduction::ReducedModel& model) {
  return diagnosis::candidate_parameters(specimen.nominal(), specimen.blank(load), model.parts.has_value());
}

/// Heat on the skin that no source has, of 15 to 150 W.
Truth drawn_spot(const Specimen& specimen, const std::string& load, Random& random) {
  Truth truth;
  truth.parameter = diagnosis::make_parameter(Kind::source_missing, "");
  auto source = std::make_shared<diagnosis::MissingSource>();
  std::tie(source->body, source->centre) = drawn_place(specimen.mesh(), random);
  const std::vector<Followable> inputs = specimen.followable(load);
  const Followable& input = inputs[random.index(inputs.size())];
  source->follows = input.channel;
  source->at = source->most = input.most;
  truth.parameter.where =
      fmt::format("{} at {:.0f} {:.0f} {:.0f} mm following {}", source->body, 1e3 * source->centre.x(),
                  1e3 * source->centre.y(), 1e3 * source->centre.z(), input.channel);
  truth.parameter.missing = std::move(source);
  truth.value = 15.0 * std::pow(10.0, random.uniform());
  return truth;
}

Truth drawn_truth(const Specimen& specimen, const std::string& load, const std::vector<Parameter>& all, Kind kind,
                  Random& random) {
  if (kind == Kind::source_missing) return drawn_spot(specimen, load, random);
  std::vector<Parameter> places;
  for (const Parameter& p : all)
    if (p.kind == kind) places.push_back(p);
  if (places.empty()) {
    throw core::UsageError(
        fmt::format("kind {}: the machine has no place for it under the load {}", name_of(kind), load));
  }
  Truth truth;
  truth.parameter = places[random.index(places.size())];
  truth.value = drawn_value(truth.parameter, random);
  return truth;
}

double heldout_square(const diagnosis::Problem& problem, const VectorXd& predicted) {
  double sum = 0.0;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const diagnosis::ObservedChannel& channel = problem.observations.channels[k];
    const Index first = problem.first_row(k) + channel.fitted, n = channel.size() - channel.fitted;
    sum += ((problem.measured - predicted).segment(first, n).array() / std::max(channel.channel.uncertainty, 1e-9))
               .square()
               .sum();
  }
  return sum;
}

/// What the diagnosis says, or where it names nothing what leads its ranking; empty: no cause.
/// @return nothing where something unknown leads
std::optional<std::vector<Truth>> preferred(const diagnosis::Diagnosis& d) {
  std::vector<Truth> causes;
  for (const diagnosis::RankedCause& cause : d.causes) causes.push_back({cause.parameter, cause.value});
  if (!causes.empty() || d.ranking.empty()) return causes;
  const diagnosis::RankedCause& first = d.ranking.front();
  if (first.parameter.kind == Kind::none) return causes;
  if (first.parameter.name.empty()) return std::nullopt;
  return std::vector<Truth>{{first.parameter, first.value}};
}

}  // namespace

std::vector<Kind> offered_kinds(const Specimen& specimen, const std::string& load,
                                const reduction::ReducedModel& model) {
  std::vector<Kind> kinds;
  for (const Parameter& p : candidates(specimen, load, model)) {
    if (p.kind != Kind::process_heat && std::find(kinds.begin(), kinds.end(), p.kind) == kinds.end())
      kinds.push_back(p.kind);
  }
  if (!model.patches.items.empty()) kinds.push_back(Kind::source_missing);
  return kinds;
}

Draw draw_set(const Specimen& specimen, Expectations& expectations, Group group, Kind kind, const std::string& load,
              std::uint64_t seed) {
  Random random(seed * 2654435761u + 17);
  Draw draw;
  draw.load = load;
  draw.seed = seed;
  const std::vector<Parameter> all = candidates(specimen, load, expectations.model());
  const auto clear = [&](const Truth& truth) {
    const Factors factors = expectations.of(truth, load);
    return factors.against_none >= 20.0 && factors.against_rival >= 10.0;
  };
  const auto clear_truth = [&](Kind of_kind, int tries) {
    Truth truth = drawn_truth(specimen, load, all, of_kind, random);
    for (int t = 1; t < tries && !clear(truth); ++t) truth = drawn_truth(specimen, load, all, of_kind, random);
    return truth;
  };
  if (group == Group::single) draw.truths.push_back(clear_truth(kind, 6));
  if (group == Group::pair) {
    const std::vector<Kind> kinds = offered_kinds(specimen, load, expectations.model());
    // Two kinds that the load shows, else any two.
    for (int tries = 0; tries < 30 && draw.truths.size() < 2; ++tries) {
      const Kind other = kinds[random.index(kinds.size())];
      if (!draw.truths.empty() && draw.truths.front().parameter.kind == other) continue;
      const Truth truth = clear_truth(other, 3);
      if (tries + 2 - std::ssize(draw.truths) >= 30 || clear(truth)) draw.truths.push_back(truth);
    }
  }
  if (group == Group::outside || group == Group::change) {
    const mesh::Machine& machine = specimen.nominal();
    draw.outside =
        group == Group::outside ? static_cast<Outside>(1 + random.index(4)) : static_cast<Outside>(5 + random.index(3));
    const auto any = [&](const auto& items) { return items[random.index(items.size())].id; };
    const bool of_joint = draw.outside == Outside::hysteretic_joint || draw.outside == Outside::lost_preload;
    draw.outside_where = of_joint                                  ? any(machine.joints)
                         : draw.outside == Outside::humid_film     ? any(machine.films)
                         : draw.outside == Outside::slipping_cable ? any(machine.sensors)
                                                                   : any(machine.sources);
  }
  return draw;
}

Line diagnose_set(const std::string& id, Group group, const Draw& draw, const compensation::Measurement& measurement,
                  const reduction::ReducedModel& model, const Beside& beside, const std::vector<double>& effective) {
  Line line;
  line.id = id;
  line.group = group_names[static_cast<int>(group)];
  const auto began = std::chrono::steady_clock::now();
  const diagnosis::Diagnosis d = diagnosis::diagnose(model, measurement, beside.how);
  line.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  line.verdict = d.verdict;
  // What is found in words of what is hidden.
  const auto words = [&](const Parameter& found) -> std::pair<std::string, std::string> {
    for (const Truth& truth : draw.truths)
      if (same_cause(found, truth.parameter)) return {name_of(found.kind), truth.parameter.where};
    return {name_of(found.kind), found.missing ? found.where + " following " + found.missing->follows : found.where};
  };
  for (const diagnosis::RankedCause& cause : d.ranking) {
    if (cause.parameter.name.empty()) continue;
    std::tie(line.named_kind, line.named_where) = words(cause.parameter);
    line.named_probability = cause.probability;
    break;
  }
  std::set<std::string> named;
  for (const auto* list : {&d.causes, &d.ambiguous_set}) {
    for (const diagnosis::RankedCause& cause : *list)
      named.insert(words(cause.parameter).first + " " + words(cause.parameter).second);
  }
  for (const std::string& name : named) line.set += (line.set.empty() ? "" : "; ") + name;
  if (draw.outside != Outside::none) {
    static constexpr const char* names[] = {"none",           "hysteretic_joint", "humid_film",
                                            "slipping_cable", "jumping_bearing",  "relubricated_bearing",
                                            "lost_preload",   "viscous_bearing"};
    line.kind = names[static_cast<int>(draw.outside)];
    line.where = draw.outside_where;
  }
  const mesh::Machine& machine = model.machine;
  if (beside.affected && beside.unaffected) {
    // What is left of the effect when every nominal uncertainty has taken what it can.
    const Seen without(model, *beside.unaffected, {}, beside.how);
    const diagnosis::Problem& problem = without.problem();
    const VectorXd effect =
        diagnosis::observe(*beside.affected, machine, solver::Channels(machine), {}).stacked() - problem.measured;
    const diagnosis::Whitener whitener(problem.fitted_covariance());
    const diagnosis::LinearEvidence evidence(whitener.whiten(problem.fitted(problem.columns)),
                                             whitener.whiten(problem.fitted(effect)), problem.prior_std);
    line.against_none = line.against_rival = evidence.chi_square();
    for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
      const int which[] = {static_cast<int>(i)};
      const double width[] = {problem.parameters[i].cause_std};
      if (const double left = evidence.widen(which, width).chi_square; left < line.against_rival)
        line.against_rival = left, line.rival = name_of(problem.parameters[i].kind) + " " + problem.parameters[i].where;
    }
  }
  if (draw.truths.empty()) return line;

  const Truth& truth = draw.truths.front();
  line.kind = name_of(truth.parameter.kind);
  line.where = truth.parameter.where;
  line.value = effective.empty() ? truth.value : effective.front();
  line.nominal_std = truth.parameter.nominal_std;
  double rank = 0.0;
  for (const diagnosis::RankedCause& cause : d.ranking) {
    if (cause.parameter.name.empty()) continue;
    rank += 1.0;
    if (truth.parameter.missing && cause.parameter.missing && line.place_error == Line::absent) {
      line.place_error = 1e3 * distance(cause.parameter, truth.parameter);
      line.region = 1e3 * cause.parameter.missing->region95;
      if (machine.sensors.size() >= 12) line.place_allowed = std::max(100.0, 0.06 * 1e3 * beside.diagonal_m);
      line.follows_right = may_follow(*cause.parameter.missing, truth.parameter.missing->follows);
    }
    if (!same_cause(cause.parameter, truth.parameter) || line.rank > 0) continue;
    line.rank = rank;
    line.probability = cause.probability;
    line.estimate = cause.value;
    line.std = cause.std;
  }
  if (draw.truths.size() > 1) {
    line.kind2 = name_of(draw.truths[1].parameter.kind);
    line.where2 = draw.truths[1].parameter.where;
    line.second_named = named.count(line.kind2 + " " + line.where2) > 0;
    const Seen seen(model, measurement, {}, beside.how);
    const Truth first{truth.parameter, line.value},
        second{draw.truths[1].parameter, effective.size() > 1 ? effective[1] : draw.truths[1].value};
    const Factors one = seen.factors_beside(first, second), two = seen.factors_beside(second, first);
    line.against_none = std::min(one.against_none, two.against_none);
    line.against_rival = std::min(one.against_rival, two.against_rival);
    line.rival = one.against_rival < two.against_rival ? one.rival : two.rival;
    return line;
  }
  const Seen seen(model, measurement, beside.inputs, beside.how);
  const Factors factors = seen.factors({truth.parameter, line.value});
  line.against_none = factors.against_none;
  line.against_rival = factors.against_rival;
  line.rival = factors.rival;
  if (const auto odds = refitted_log_odds(seen, machine, {{truth.parameter, line.value}})) {
    if (const auto winner = preferred(d))
      if (const auto other = refitted_log_odds(seen, machine, *winner)) line.refit_over_winner = *odds - *other;
  }
  mesh::Machine found = machine;
  for (const diagnosis::RankedCause& cause : d.causes) {
    if (d.verdict == diagnosis::Verdict::explained)
      found = diagnosis::with_parameter(found, cause.parameter, cause.value);
  }
  const mesh::Machine right = diagnosis::with_parameter(machine, on_model(truth.parameter, model), line.value);
  if (d.verdict == diagnosis::Verdict::explained) {
    const double before = heldout_square(seen.problem(), seen.problem().predicted),
                 after = heldout_square(seen.problem(), seen.response().predict(found)),
                 best = heldout_square(seen.problem(), seen.response().predict(right));
    if (before > 1.05 * best) line.gain = (before - after) / (before - best);
  }
  if (beside.unseen && line.identifiable()) {
    const compensation::Measurement unseen = beside.unseen();
    const Seen program(model, unseen, {}, beside.how);
    const auto fill = [&](const mesh::Machine& corrected, double& heldout, double& at_poses, double& elsewhere) {
      const VectorXd predicted = program.response().predict(corrected);
      heldout = displacement_rms(seen, seen.response().predict(corrected), true, {});
      at_poses = displacement_rms(program, predicted, false, {1, beside.measured_poses});
      elsewhere = displacement_rms(program, predicted, false, {beside.measured_poses + 1});
    };
    fill(machine, line.heldout_before, line.program_before, line.poses_before);
    fill(found, line.heldout_after, line.program_after, line.poses_after);
    fill(right, line.heldout_truth, line.program_truth, line.poses_truth);
    const std::vector<Corrected> others = baselines(seen, measurement, program, unseen, machine);
    line.refit_heldout = others[0].heldout_um, line.refit_program = others[0].program_um;
    line.refit_right = others[0].kind == line.kind && others[0].where == line.where;
    line.process_heldout = others[1].heldout_um, line.process_program = others[1].program_um;
    line.sparse_heldout = others[2].heldout_um, line.sparse_program = others[2].program_um;
  }
  return line;
}

}  // namespace thermotwin::hidden
