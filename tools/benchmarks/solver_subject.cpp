// SPDX-License-Identifier: GPL-3.0-or-later
// The full model: one body against a bare CHOLMOD program and CalculiX, one thread against more, nine
// loads at once against one, a factor against multigrid; the whole machine's loads and poses.
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
  command.words = {(s.programs / "bench_worker").string(),
                   verb,
                   "--case",
                   s.case_path.string(),
                   "--size",
                   s.size,
                   "--body",
                   s.body,
                   "--folder",
                   s.work.string(),
                   "--threads",
                   std::to_string(threads)};
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
  if (!(std::abs(ours - other) <= tolerance * std::abs(other))) {
    throw core::SolverError(fmt::format(
        "{}: {} here, {} by the alternative: no comparison of times between different answers", what, ours, other));
  }
}

std::vector<double> sum(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

std::vector<double> values(const std::vector<Outcome>& outcomes, const std::string& name) {
  return each(outcomes, name);
}

/// Against CalculiX: what further time steps or static steps add to a run on the same mesh, on the
/// same processors.
void against_calculix(const Settings& s, Report& report) {
  if (!have_program("ccx")) return report.note("CalculiX (ccx) is not installed: left out");
  const auto ccx = [&](const std::string& deck) {
    Command command;
    command.words = {"ccx", deck};
    command.folder = s.work;
    command.cores = s.threads;
    command.environment = {"OMP_NUM_THREADS=" + std::to_string(s.threads), "OPENBLAS_NUM_THREADS=1"};
    return run(command);
  };
  const auto time = [&](const Outcome& outcome) {
    return s.threads == 1 ? outcome.processor_seconds : outcome.seconds;
  };
  std::vector<double> step, bend, our_step, our_bend;
  double MiB = 0, heat_MiB = 0, elastic_MiB = 0;
  for (int i = 0; i < std::min(3, s.pairs); ++i) {
    const Outcome heat = run(worker(s, "heat", s.threads, {"--steps", std::to_string(s.steps)})),
                  elastic = run(worker(s, "elastic", s.threads));
    const Outcome longer = ccx("heat_long"), bent = ccx("bend_long");
    step.push_back((time(longer) - time(ccx("heat_short"))) / s.deck_steps);
    bend.push_back((time(bent) - time(ccx("bend_short"))) / 2);
    MiB = std::max({MiB, longer.peak_MiB, bent.peak_MiB});
    our_step.push_back(heat["step"]);
    our_bend.push_back(elastic["assembly"] + elastic["factor"] + elastic["rows"]);
    heat_MiB = heat.peak_MiB;
    elastic_MiB = elastic.peak_MiB;
  }
  report.compare("thermal step", our_step, step, "CalculiX, which factorises in each", s.threads, heat_MiB, MiB);
  report.compare("elastic: assembly, factor, 48 rows", our_bend, bend, "CalculiX, a step of one load", s.threads,
                 elastic_MiB, MiB);
  report.note(fmt::format("CalculiX: what {} more time steps, or two more static ones, add to a run", s.deck_steps));
}

/// Loads side by side.
void block_of_loads(const Settings& s, Report& report) {
  const std::string steps = std::to_string(std::min(s.steps, 40));
  const auto heat = [&](int columns, int threads) {
    return worker(s, "heat", threads, {"--steps", steps, "--columns", std::to_string(columns)});
  };
  const Pairs nine = in_turn(s.pairs, heat(9, 1), heat(1, 1));
  std::vector<double> alone = values(nine.other, "step"), cost;
  for (std::size_t i = 0; i < alone.size(); ++i) cost.push_back(nine.ours[i]["step"] / alone[i]);
  for (double& step : alone) step *= 9;
  report.compare("thermal step of nine loads side by side", values(nine.ours, "step"), alone, "nine steps of one load",
                 1, median(each(nine.ours, "MiB")), median(each(nine.other, "MiB")));
  report.figure("  that is, of the step of one load", fmt::format("{:.2f} x", median(cost)), 1);
}

/// What more threads do for the steps, and how near the solves are to what memory gives. Wall time: the
/// machine must have nothing else to do.
void threads(const Settings& s, Report& report) {
  const std::string steps = std::to_string(std::min(s.steps, 40));
  double alone = 0;
  for (const int count : {1, s.threads}) {
    const Outcome memory = run(worker(s, "memory", count, {"--wall"}));
    if (count == 1) alone = memory["GB_s"];
    report.figure("memory is read at",
                  fmt::format("{:.1f} GB/s, {:.2f} x one thread", memory["GB_s"], memory["GB_s"] / alone), count);
  }
  for (const int columns : {1, 9}) {
    const auto heat = [&](int count) {
      return worker(s, "heat", count, {"--steps", steps, "--columns", std::to_string(columns), "--wall"});
    };
    const Pairs pairs = in_turn(std::min(s.pairs, 3), heat(s.threads), heat(1));
    const std::vector<double> ours = values(pairs.ours, "step"), one = values(pairs.other, "step");
    report.compare(fmt::format("thermal step, {} load{}", columns, columns > 1 ? "s" : ""), ours, one, "one thread",
                   s.threads);
    // Two stages, each with a sweep forward and one backward.
    const double read = 4 * pairs.ours[0]["factor_GB"];
    report.figure("  of the factor, with one thread",
                  fmt::format("{:.2f} GB a step, {:.1f} GB/s", read, read / median(one)), 1);
    report.figure("  with all", fmt::format("{:.1f} GB/s", read / median(ours)), s.threads);
  }
}

void multigrid(const Settings& s, Report& report, const std::vector<Outcome>& direct) {
  std::vector<double> solve, factor;
  Outcome last;
  for (std::size_t i = 0; i < std::min<std::size_t>(2, direct.size()); ++i) {
    last = run(worker(s, "iterative", 1));
    solve.push_back(last["setup"] + last["rows"]);
    factor.push_back(direct[i]["factor"] + direct[i]["rows"] * last["columns"] / 48);
  }
  report.compare(fmt::format("multigrid: levels, {} rows to 1e-8", last["columns"]), solve, factor,
                 "a factor, as many rows", 1, last.peak_MiB, median(each(direct, "MiB")));
  report.figure("  iterations", fmt::format("{}", last["iterations"]), 1);
  report.figure("  multigrid itself, MiB", fmt::format("{:.0f}", last["multigrid_MiB"]), 1);
}

void single_body(const Settings& s, Report& report) {
  const Outcome files = run(worker(s, "files", 1, {"--deck-steps", std::to_string(s.deck_steps)}));
  report.note(fmt::format("one body: {} of {}, {} nodes, {} tetrahedra; one processor, its time", s.body,
                          s.case_path.string(), files["nodes"], files["elements"]));
  const std::string steps = std::to_string(s.steps), cholmod = "bare CHOLMOD";
  const Pairs heat = in_turn(s.pairs, worker(s, "heat", 1, {"--steps", steps}), bare(s, {"heat", steps}));
  require_equal("largest temperature after the steps", heat.ours[0]["largest_K"], heat.other[0]["largest_K"], 1e-6);
  require_equal("mean temperature after the steps", heat.ours[0]["mean_K"], heat.other[0]["mean_K"], 1e-6);
  const double ours_MiB = median(each(heat.ours, "MiB")), other_MiB = median(each(heat.other, "MiB"));
  report.compare("thermal step (two stages)", values(heat.ours, "step"), values(heat.other, "step"), cholmod, 1,
                 ours_MiB, other_MiB);
  report.compare("thermal assembly, factor", sum(values(heat.ours, "assembly"), values(heat.ours, "first_step")),
                 sum(values(heat.other, "assembly"), values(heat.other, "factor")), cholmod, 1);
  const Pairs elastic = in_turn(s.pairs, worker(s, "elastic", 1), bare(s, {"elastic"}));
  require_equal("norm of the adjoint rows", elastic.ours[0]["rows_norm"], elastic.other[0]["rows_norm"], 1e-6);
  report.compare("elastic assembly", values(elastic.ours, "assembly"), values(elastic.other, "assembly"), cholmod, 1,
                 median(each(elastic.ours, "MiB")), median(each(elastic.other, "MiB")));
  report.compare("elastic factor", values(elastic.ours, "factor"), values(elastic.other, "factor"), cholmod, 1);
  report.compare("48 adjoint rows", values(elastic.ours, "rows"), values(elastic.other, "rows"), cholmod, 1);
  report.note(fmt::format("the answers of both agree: temperatures to {:.0e}, rows to {:.0e}",
                          std::abs(heat.ours[0]["mean_K"] / heat.other[0]["mean_K"] - 1),
                          std::abs(elastic.ours[0]["rows_norm"] / elastic.other[0]["rows_norm"] - 1)));
  block_of_loads(s, report);
  if (s.threads > 1) threads(s, report);
  multigrid(s, report, elastic.ours);
  against_calculix(s, report);
}

void whole_machine(const Settings& s, Report& report) {
  const std::string steps = std::to_string(std::min(s.steps, 60));
  for (const auto& [set, what] : {std::pair{"ambient", "a load's step, nine ambient cycles in a block"},
                                  std::pair{"warm_up", "a load's step, nine warm-ups in a block"}}) {
    run(worker(s, "loads", s.threads, {"--steps", "1", "--set", set}));  // fills the mesh cache
    const Pairs pairs = in_turn(std::min(s.pairs, 3), worker(s, "loads", s.threads, {"--steps", steps, "--set", set}),
                                worker(s, "loads", s.threads, {"--steps", steps, "--set", set, "--apart"}));
    require_equal("mean temperature of the nine loads", pairs.ours[0]["mean_K"], pairs.other[0]["mean_K"], 1e-5);
    report.compare(what, values(pairs.ours, "load_step"), values(pairs.other, "load_step"), "one after the other",
                   s.threads, median(each(pairs.ours, "MiB")), median(each(pairs.other, "MiB")));
  }
  std::vector<double> all, anew, cost;
  Outcome last;
  for (int i = 0; i < std::min(s.pairs, 3); ++i) {
    last = run(worker(s, "poses", s.threads));
    all.push_back(last["model"] + last["all_poses"]);
    cost.push_back(all.back() / (last["model"] + last["pose"]));
    anew.push_back(last["poses"] * (last["model"] + last["pose"]));
  }
  report.compare(fmt::format("elastic model and rows of {} poses", last["poses"]), all, anew,
                 "a new elastic model a pose (one measured, times the poses)", s.threads, last.peak_MiB, 0);
  report.figure(fmt::format("  {} poses, of the model with one pose", last["poses"]),
                fmt::format("{:.2f} x", median(cost)), s.threads);
  report.figure(fmt::format("  of it: factors and {} unit solves", last["unit_solves"]), duration(last["model"]),
                s.threads);
  report.figure("  of it: rows of one pose", duration(last["pose"]), s.threads);
  report.note(fmt::format("whole machine: {} nodes; {} steps a load; {}", last["nodes"], steps,
                          s.threads == 1 ? "one processor, its time" : "wall time"));
}

}  // namespace

std::string solver_subject(const Settings& settings) {
  Report report("solver, " + settings.size);
  single_body(settings, report);
  if (!settings.bodies_only) whole_machine(settings, report);
  return report.text();
}

}  // namespace thermotwin::bench
