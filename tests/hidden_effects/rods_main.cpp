// SPDX-License-Identifier: GPL-3.0-or-later
// The bank on the network of three rods of tests/diagnosis: a set takes seconds, so that thresholds and
// priors can be judged on hundreds. What is hidden has the hypothesis' own footprint and time course; the
// measured network is finer, in other steps, with perturbed nominal values and noise.
// usage: hidden_effects_rods DRAWS CLEAN PAIRS SEED [KIND]
#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <map>

#include "bank.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::Parameter;

double drawn_value(const Parameter& p, hidden::Random& random) {
  const double least = 4.2 * p.nominal_std, most = std::max(1.3 * least, 1.2 * p.cause_std);
  if (p.kind == Kind::sensor_lag) return random.uniform(900.0, 3600.0);
  if (p.kind == Kind::sensor_detached) return random.uniform(0.3, 0.95);
  const double by = p.kind == Kind::clock_shift     ? random.uniform(900.0, 5400.0)
                    : p.kind == Kind::sensor_offset ? random.uniform(0.4, 2.0)
                                                    : random.uniform(least, most);
  const bool down = random.uniform() < 0.5;
  if (p.ratio) return down ? 1.0 / (1.0 + by) : 1.0 + by;
  const double value = down ? -by : by;
  return value < p.low ? by : value;
}

int run(int draws, int clean, int pairs, std::uint64_t seed, const std::string& only) {
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  const std::vector<Parameter> all =
      diagnosis::candidate_parameters(lumped::machine(), lumped::measure({}, {.hours = 0.1}));
  std::map<std::string, std::vector<Parameter>> kinds;
  for (const Parameter& p : all)
    if (only.empty() || name_of(p.kind) == only) kinds[name_of(p.kind)].push_back(p);
  std::vector<hidden::Line> lines;
  hidden::Beside beside;
  beside.how.temperature_error_percent = 3.0;  // 27 nodes
  const auto one = [&](hidden::Group group, const std::vector<hidden::Truth>& truths, const std::string& id) {
    hidden::Draw draw;
    draw.truths = truths;
    draw.seed = ++seed;
    std::vector<std::pair<Parameter, double>> faults;
    for (const hidden::Truth& truth : truths) faults.emplace_back(truth.parameter, truth.value);
    lines.push_back(hidden::diagnose_set(id, group, draw, lumped::measure(faults, {.seed = draw.seed, .spread = 1.0}),
                                         model, beside));
    std::cerr << lines.back().text() << "\n";
  };
  for (int i = 0; i < draws; ++i) {
    for (const auto& [kind, places] : kinds) {
      hidden::Random random(77 * (seed + 1));
      const Parameter& p = places[random.index(places.size())];
      one(hidden::Group::single, {{p, drawn_value(p, random)}}, fmt::format("{}_{}", kind, i));
    }
  }
  for (int i = 0; i < clean; ++i) one(hidden::Group::clean, {}, fmt::format("clean_{}", i));
  for (int i = 0; i < pairs; ++i) {
    hidden::Random random(77 * (seed + 1) + i);
    const Parameter &a = all[random.index(all.size())], &b = all[random.index(all.size())];
    if (a.kind != b.kind)
      one(hidden::Group::pair, {{a, drawn_value(a, random)}, {b, drawn_value(b, random)}}, fmt::format("pair_{}", i));
  }
  std::cout << hidden::score(lines);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc >= 5) {
      return run(std::stoi(argv[1]), std::stoi(argv[2]), std::stoi(argv[3]), std::stoull(argv[4]),
                 argc > 5 ? argv[5] : "");
    }
    std::cerr << "usage: hidden_effects_rods DRAWS CLEAN PAIRS SEED [KIND]\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 3;
  }
}
