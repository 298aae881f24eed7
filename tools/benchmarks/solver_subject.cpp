// SPDX-License-Identifier: GPL-3.0-or-later
// The full model: one body against a bare CHOLMOD program and CalculiX; nine loads at once against
// one after the other; 27 poses against one.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {
namespace {

Command worker(const Settings& s, const std::string& verb, int threads, std::vector<std::string> more = {}) {
  Command command;
  command.words = {(s.programs / "bench_worker").string(), verb, "--case", s.case_path.string(), "--size", s.size, "--body", s.body,
                   "--folder", s.work.string(), "--threads", std::to_string(threads)};
  command.words.insert(command.words.end(), more.begin(), more.end());
  if (threads == 1) command.cores = 1;
  return command;
}

Command bare(const Settings& s, std::vector<std::string> arguments) {
  Command command;
  command.words = {(s.programs / "bench_cholmod").string(), (s.work / "body.txt").string()};
  command.words.insert(command.words.end(), arguments.begin(), arguments.end());
  command.cores = 1;
  command.environment = {"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1"};
  return command;
}

void require_equal(const std::string& what, double ours, double other, double tolerance) {
  if (!(std::abs(ours - other) <= tolerance * std::abs(other)))
    throw core::SolverError(fmt::format("{}: {} here, {} by the alternative: no comparison of times between different answers", what, ours, other));
}

std::vector<double> sum(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

std::vector<double> values(const std::vector<Outcome>& outcomes, const std::string& name) { return each(outcomes, name); }

/// Against CalculiX: what further time steps or static steps add to a run on the same mesh.
void against_calculix(const Settings& s, Report& report, const std::vector<Outcome>& heat, const std::vector<Outcome>& elastic, int steps) {
  if (!have_program("ccx")) return report.note("CalculiX (ccx) is not installed: left out");
  const auto ccx = [&](const std::string& deck) {
    Command command;
    command.words = {"ccx", deck};
    command.folder = s.work;
    command.cores = 1;
    command.environment = {"OMP_NUM_THREADS=1", "OPENBLAS_NUM_THREADS=1"};
    return run(command);
  };
  std::vector<double> step, bend, our_step, our_bend;
  double MiB = 0;
  const std::size_t repeats = std::min<std::size_t>(3, heat.size());
  for (std::size_t i = 0; i < repeats; ++i) {
    const Outcome longer = ccx("heat_long"), bent = ccx("bend_long");
    step.push_back((longer.processor_seconds - ccx("heat_short").processor_seconds) / steps);
    bend.push_back((bent.processor_seconds - ccx("bend_short").processor_seconds) / 2);
    MiB = std::max({MiB, longer.peak_MiB, bent.peak_MiB});
    our_step.push_back(heat[i]["step"]);
    our_bend.push_back(elastic[i]["assembly"] + elastic[i]["factor"] + elastic[i]["rows"]);
  }
  report.compare("thermal step", our_step, step, "CalculiX, which factorises in each", 1, median(each(heat, "MiB")), MiB);
  report.compare("elastic: assembly, factor, 48 rows", our_bend, bend, "CalculiX, a step of one load", 1, median(each(elastic, "MiB")), MiB);
}

void single_body(const Settings& s, Report& report) {
  constexpr int deck_steps = 6;
  const Outcome files = run(worker(s, "files", 1, {"--deck-steps", std::to_string(deck_steps)}));
  report.note(fmt::format("one body: {} of {}, {} nodes, {} tetrahedra; one processor, its time", s.body, s.case_path.string(), files["nodes"], files["elements"]));
  const std::string steps = std::to_string(s.steps), cholmod = "bare CHOLMOD";
  const Pairs heat = in_turn(s.pairs, worker(s, "heat", 1, {"--steps", steps}), bare(s, {"heat", steps}));
  require_equal("largest temperature after the steps", heat.ours[0]["largest_K"], heat.other[0]["largest_K"], 1e-6);
  require_equal("mean temperature after the steps", heat.ours[0]["mean_K"], heat.other[0]["mean_K"], 1e-6);
  const double ours_MiB = median(each(heat.ours, "MiB")), other_MiB = median(each(heat.other, "MiB"));
  report.compare("thermal step (two stages)", values(heat.ours, "step"), values(heat.other, "step"), cholmod, 1, ours_MiB, other_MiB);
  report.compare("thermal assembly, factor", sum(values(heat.ours, "assembly"), values(heat.ours, "first_step")),
                 sum(values(heat.other, "assembly"), values(heat.other, "factor")), cholmod, 1);
  const Pairs elastic = in_turn(s.pairs, worker(s, "elastic", 1), bare(s, {"elastic"}));
  require_equal("norm of the adjoint rows", elastic.ours[0]["rows_norm"], elastic.other[0]["rows_norm"], 1e-6);
  report.compare("elastic assembly", values(elastic.ours, "assembly"), values(elastic.other, "assembly"), cholmod, 1,
                 median(each(elastic.ours, "MiB")), median(each(elastic.other, "MiB")));
  report.compare("elastic factor", values(elastic.ours, "factor"), values(elastic.other, "factor"), cholmod, 1);
  report.compare("48 adjoint rows", values(elastic.ours, "rows"), values(elastic.other, "rows"), cholmod, 1);
  report.note(fmt::format("the answers of both agree: temperatures to {:.0e}, rows to {:.0e}",
                          std::abs(heat.ours[0]["mean_K"] / heat.other[0]["mean_K"] - 1), std::abs(elastic.ours[0]["rows_norm"] / elastic.other[0]["rows_norm"] - 1)));
  against_calculix(s, report, heat.ours, elastic.ours, deck_steps);
}

void whole_machine(const Settings& s, Report& report) {
  const std::string steps = std::to_string(std::min(s.steps, 60));
  for (const auto& [set, what] : {std::pair{"ambient", "a load's step, nine ambient cycles in a block"}, std::pair{"warm_up", "a load's step, nine warm-ups in a block"}}) {
    run(worker(s, "loads", s.threads, {"--steps", "1", "--set", set}));  // fills the mesh cache
    const Pairs pairs = in_turn(std::min(s.pairs, 3), worker(s, "loads", s.threads, {"--steps", steps, "--set", set}),
                                worker(s, "loads", s.threads, {"--steps", steps, "--set", set, "--apart"}));
    require_equal("mean temperature of the nine loads", pairs.ours[0]["mean_K"], pairs.other[0]["mean_K"], 1e-5);
    report.compare(what, values(pairs.ours, "load_step"), values(pairs.other, "load_step"), "one after the other", s.threads,
                   median(each(pairs.ours, "MiB")), median(each(pairs.other, "MiB")));
  }
  std::vector<double> all, anew;
  Outcome last;
  for (int i = 0; i < std::min(s.pairs, 3); ++i) {
    last = run(worker(s, "poses", s.threads));
    all.push_back(last["model"] + last["all_poses"]);
    anew.push_back(last["poses"] * (last["model"] + last["pose"]));
  }
  report.compare(fmt::format("elastic model and rows of {} poses", last["poses"]), all, anew,
                 "a new elastic model a pose (one measured, times the poses)", s.threads, last.peak_MiB, 0);
  report.figure(fmt::format("  of it: factors and {} unit solves", last["unit_solves"]), duration(last["model"]), s.threads);
  report.figure("  of it: rows of one pose", duration(last["pose"]), s.threads);
  report.note(fmt::format("whole machine: {} nodes; {} steps a load; {}", last["nodes"], steps, s.threads == 1 ? "one processor, its time" : "wall time"));
}

}  // namespace

std::string solver_subject(const Settings& settings) {
  Report report("solver, " + settings.size);
  single_body(settings, report);
  whole_machine(settings, report);
  return report.text();
}

}  // namespace thermotwin::bench
