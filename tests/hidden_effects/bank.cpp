// SPDX-License-Identifier: GPL-3.0-or-later
#include "bank.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>
#include <sstream>

#include "diagnosis/evidence.h"
#include "diagnosis/problem.h"
#include "diagnosis/response.h"

namespace thermotwin::hidden {

using diagnosis::Parameter;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr const char* group_names[] = {"single", "clean", "pair", "outside"};

/// A wrong value: at least four of its standard deviations away, a share of what causes may be.
double drawn_value(const Parameter& p, Random& random) {
  const double least = 4.2 * p.nominal_std, most = std::max(1.3 * least, 1.2 * p.cause_std);
  double by = random.uniform(least, most);
  if (p.kind == "sensor_lag") return random.uniform(900.0, 3600.0);
  if (p.kind == "sensor_detached") return random.uniform(0.3, 0.95);
  if (p.kind == "clock_shift") by = random.uniform(900.0, 5400.0);
  if (p.kind == "sensor_offset") by = random.uniform(0.4, 2.0);
  const bool down = random.uniform() < 0.5;
  // What is multiplied falls as often as it rises, as far on a scale of logarithms.
  if (p.ratio) return down ? 1.0 / (1.0 + by) : 1.0 + by;
  const double value = down ? -by : by;
  return value < p.low ? by : value;
}

std::vector<Parameter> candidates(const Specimen& specimen, const std::string& load) {
  return diagnosis::candidate_parameters(specimen.nominal(), specimen.blank(load));
}

Truth drawn_truth(const std::vector<Parameter>& all, const std::string& kind, Random& random) {
  std::vector<Parameter> places;
  for (const Parameter& p : all)
    if (p.kind == kind) places.push_back(p);
  Truth truth;
  truth.parameter = places[random.index(places.size())];
  truth.value = drawn_value(truth.parameter, random);
  return truth;
}

bool same(const Parameter& a, const Parameter& b) { return a.kind == b.kind && a.where == b.where; }

/// What the truth is expected to show, on the linearisation at nominal and with all nuisances.
void expected_factors(const diagnosis::Problem& problem, const Truth& truth, Line& line) {
  const diagnosis::Whitener whitener(problem.fitted_covariance());
  const Eigen::MatrixXd columns = whitener.whiten(problem.fitted(problem.columns));
  int at = -1;
  for (std::size_t i = 0; i < problem.parameters.size(); ++i)
    if (same(problem.parameters[i], truth.parameter)) at = static_cast<int>(i);
  if (at < 0) return;
  const VectorXd signal = columns.col(at) * (truth.value - truth.parameter.nominal);
  const diagnosis::LinearEvidence evidence(columns, signal, problem.prior_std);
  const auto ratio = [&](int i) {
    const double width[] = {problem.parameters[static_cast<std::size_t>(i)].cause_std};
    const int which[] = {i};
    return evidence.widen(which, width).log_ratio;
  };
  const double own = ratio(at);
  line.against_none = 2.0 * own;
  double rival = 0.0;
  for (std::size_t i = 0; i < problem.parameters.size(); ++i) {
    if (static_cast<int>(i) == at) continue;
    const double other = ratio(static_cast<int>(i));
    if (other > rival) rival = other, line.rival = problem.parameters[i].kind + " " + problem.parameters[i].where;
  }
  line.against_rival = 2.0 * (own - rival);
}

double heldout_square(const diagnosis::Problem& problem, const VectorXd& predicted) {
  double sum = 0.0;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const diagnosis::ObservedChannel& channel = problem.observations.channels[k];
    const Index first = problem.first_row(k) + channel.fitted, n = channel.size() - channel.fitted;
    sum += ((problem.measured - predicted).segment(first, n).array() / std::max(channel.channel.uncertainty, 1e-9)).square().sum();
  }
  return sum;
}

}  // namespace

std::string Line::header() {
  return "id\tgroup\tkind\twhere\tkind2\twhere2\tvalue\tnominal_std\tagainst_none\tagainst_rival\trival\tverdict\tnamed_kind\tnamed_where\t"
         "set\tprobability\trank\testimate\tstd\tnamed_probability\tgain\tseconds\tsecond_named";
}

std::string Line::text() const {
  return fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{:.6g}\t{:.6g}\t{:.6g}\t{:.6g}\t{}\t{}\t{}\t{}\t{}\t{:.6g}\t{:.6g}\t{:.6g}\t{:.6g}\t{:.6g}\t{:.6g}\t{:.3g}\t{}",
                     id, group, kind, where, kind2, where2, value, nominal_std, against_none, against_rival, rival, verdict, named_kind, named_where,
                     set, probability, rank, estimate, std, named_probability, gain, seconds, second_named ? 1 : 0);
}

Line Line::parse(const std::string& text) {
  std::vector<std::string> cells;
  std::istringstream stream(text);
  for (std::string cell; std::getline(stream, cell, '\t');) cells.push_back(cell);
  Line line;
  if (cells.size() < 23) return line;
  line.id = cells[0], line.group = cells[1], line.kind = cells[2], line.where = cells[3], line.kind2 = cells[4], line.where2 = cells[5];
  line.value = std::stod(cells[6]), line.nominal_std = std::stod(cells[7]), line.against_none = std::stod(cells[8]), line.against_rival = std::stod(cells[9]);
  line.rival = cells[10], line.verdict = cells[11], line.named_kind = cells[12], line.named_where = cells[13], line.set = cells[14];
  line.probability = std::stod(cells[15]), line.rank = std::stod(cells[16]), line.estimate = std::stod(cells[17]), line.std = std::stod(cells[18]);
  line.named_probability = std::stod(cells[19]), line.gain = std::stod(cells[20]), line.seconds = std::stod(cells[21]), line.second_named = cells[22] == "1";
  return line;
}

std::vector<std::string> offered_kinds(const Specimen& specimen, const std::string& load) {
  std::vector<std::string> kinds;
  for (const Parameter& p : candidates(specimen, load))
    if (p.kind != "process_heat" && std::find(kinds.begin(), kinds.end(), p.kind) == kinds.end()) kinds.push_back(p.kind);
  return kinds;
}

const diagnosis::Problem& Expectations::problem(const std::string& load) {
  if (const auto found = problems_.find(load); found != problems_.end()) return found->second;
  Draw clean;
  clean.load = load;
  clean.seed = 1;
  const compensation::Measurement measurement = specimen_.measure(clean);
  const mesh::Machine& machine = model_.machine;
  const diagnosis::Observations observations = diagnosis::observe(measurement, machine, solver::Channels(machine), {});
  const diagnosis::Response response(model_, observations);
  return problems_.emplace(load, diagnosis::make_problem(machine, measurement, observations, response, {})).first->second;
}

Line Expectations::of(const Truth& truth, const std::string& load) {
  Line line;
  expected_factors(problem(load), truth, line);
  return line;
}

Draw draw_set(const Specimen& specimen, Expectations& expectations, Group group, const std::string& kind, const std::string& load,
              std::uint64_t seed) {
  Random random(seed * 2654435761u + 17);
  Draw draw;
  draw.load = load;
  draw.seed = seed;
  const std::vector<Parameter> all = candidates(specimen, load);
  const auto clear_truth = [&](const std::string& of_kind, int tries) {
    Truth truth = drawn_truth(all, of_kind, random);
    for (int t = 1; t < tries && !expectations.of(truth, load).clear(); ++t) truth = drawn_truth(all, of_kind, random);
    return truth;
  };
  if (group == Group::single) draw.truths.push_back(clear_truth(kind, 6));
  if (group == Group::pair) {
    const std::vector<std::string> kinds = offered_kinds(specimen, load);
    // Two kinds that the load shows, else any two.
    for (int tries = 0; tries < 30 && draw.truths.size() < 2; ++tries) {
      const std::string& other = kinds[random.index(kinds.size())];
      if (!draw.truths.empty() && draw.truths.front().parameter.kind == other) continue;
      const Truth truth = clear_truth(other, 3);
      if (tries + 2 - static_cast<int>(draw.truths.size()) >= 30 || expectations.of(truth, load).clear()) draw.truths.push_back(truth);
    }
  }
  if (group == Group::outside) {
    const mesh::Machine& machine = specimen.nominal();
    draw.outside = static_cast<Outside>(1 + random.index(4));
    const auto any = [&](const auto& items) { return items[random.index(items.size())].id; };
    draw.outside_where = draw.outside == Outside::hysteretic_joint ? any(machine.joints)
                         : draw.outside == Outside::humid_film     ? any(machine.films)
                         : draw.outside == Outside::slipping_cable ? any(machine.sensors)
                                                                   : any(machine.sources);
  }
  return draw;
}

Line diagnose_set(const std::string& id, Group group, const Draw& draw, const compensation::Measurement& measurement,
                  const reduction::ReducedModel& model, const compensation::Measurement* clean,
                  std::optional<double> effective) {
  Line line;
  line.id = id;
  line.group = group_names[static_cast<int>(group)];
  const auto began = std::chrono::steady_clock::now();
  const diagnosis::Diagnosis d = diagnosis::diagnose(model, measurement, {});
  line.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  line.verdict = d.verdict;
  for (const diagnosis::RankedCause& cause : d.ranking) {
    if (cause.parameter.name.empty()) continue;
    line.named_kind = cause.parameter.kind;
    line.named_where = cause.parameter.where;
    line.named_probability = cause.probability;
    break;
  }
  std::set<std::string> named;
  for (const auto* list : {&d.causes, &d.ambiguous_set})
    for (const diagnosis::RankedCause& cause : *list) named.insert(cause.parameter.kind + " " + cause.parameter.where);
  for (const std::string& name : named) line.set += (line.set.empty() ? "" : "; ") + name;
  if (group == Group::outside) {
    static constexpr const char* names[] = {"none", "hysteretic_joint", "humid_film", "slipping_cable", "jumping_bearing"};
    line.kind = names[static_cast<int>(draw.outside)];
    line.where = draw.outside_where;
  }
  const mesh::Machine& machine = model.machine;
  const auto problem_of = [&](const compensation::Measurement& m, std::unique_ptr<diagnosis::Response>& response, diagnosis::Observations& observations) {
    observations = diagnosis::observe(m, machine, solver::Channels(machine), {});
    response = std::make_unique<diagnosis::Response>(model, observations);
    return diagnosis::make_problem(machine, m, observations, *response, {});
  };
  std::unique_ptr<diagnosis::Response> kept;
  diagnosis::Observations observations;
  if (clean) {
    // What is left of the effect when every nominal uncertainty has taken what it can.
    const diagnosis::Problem without = problem_of(*clean, kept, observations);
    const VectorXd effect = diagnosis::observe(measurement, machine, solver::Channels(machine), {}).stacked() - without.measured;
    const diagnosis::Whitener whitener(without.fitted_covariance());
    line.against_none = diagnosis::LinearEvidence(whitener.whiten(without.fitted(without.columns)), whitener.whiten(without.fitted(effect)), without.prior_std).chi_square();
  }
  if (draw.truths.empty()) return line;

  const Truth& truth = draw.truths.front();
  line.kind = truth.parameter.kind;
  line.where = truth.parameter.where;
  line.value = effective.value_or(truth.value);
  line.nominal_std = truth.parameter.nominal_std;
  double rank = 0.0;
  for (const diagnosis::RankedCause& cause : d.ranking) {
    if (cause.parameter.name.empty()) continue;
    rank += 1.0;
    if (!same(cause.parameter, truth.parameter)) continue;
    line.rank = rank;
    line.probability = cause.probability;
    line.estimate = cause.value;
    line.std = cause.std;
  }
  if (draw.truths.size() > 1) {
    line.kind2 = draw.truths[1].parameter.kind;
    line.where2 = draw.truths[1].parameter.where;
    line.second_named = named.count(line.kind2 + " " + line.where2) > 0;
    return line;
  }
  const diagnosis::Problem problem = problem_of(measurement, kept, observations);
  const diagnosis::Response& response = *kept;
  expected_factors(problem, truth, line);
  if (d.verdict == "explained") {
    mesh::Machine found = machine;
    for (const diagnosis::RankedCause& cause : d.causes) found = diagnosis::with_parameter(found, cause.parameter, cause.value);
    const double before = heldout_square(problem, problem.predicted), after = heldout_square(problem, response.predict(found)),
                 best = heldout_square(problem, response.predict(diagnosis::with_parameter(machine, truth.parameter, truth.value)));
    line.gain = before > best ? (before - after) / (before - best) : 0.0;
  }
  return line;
}

}  // namespace thermotwin::hidden
