// SPDX-License-Identifier: GPL-3.0-or-later
// The reduced model: its time step against the full model's on the same load, and what it costs.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <map>

#include "core/file.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {
namespace {

constexpr int online_steps = 5000;

Command reduce(const Settings& s, const std::filesystem::path& out, bool resume) {
  Command command;
  command.words = {s.thermotwin.string(),
                   "reduce",
                   s.case_path.string(),
                   "--size",
                   s.size,
                   "--out",
                   out.string(),
                   "--quiet",
                   "--json",
                   "--threads",
                   std::to_string(s.threads)};
  if (resume) command.words.push_back("--resume");
  command.output = s.work / "reduce.json";
  return command;
}

/// What making the model costs. @return its file
std::filesystem::path measure_making(const Settings& settings, Report& report) {
  const auto folder = settings.work / ("reduced_" + settings.size);
  std::filesystem::remove_all(folder / "campaign");
  const Outcome first = run(reduce(settings, folder, false)), again = run(reduce(settings, folder, true));
  const nlohmann::json json = nlohmann::json::parse(core::read_file(settings.work / "reduce.json"));
  report.figure("campaign of the case and reduction", duration(first.seconds), settings.threads, first.peak_MiB);
  report.figure("  of it: reduction, order " + std::to_string(json.at("order").get<int>()), duration(again.seconds),
                settings.threads, again.peak_MiB);
  report.figure("  of it: candidates and basis", duration(json.at("basis_s").get<double>()), settings.threads);
  for (const auto& load : json.at("heldout")) {
    report.note(fmt::format("held out {}: reduced against full {:.3f} um at most, peak {:.1f} um",
                            load.at("load").get<std::string>(), load.at("max_um").get<double>(),
                            load.at("peak_um").get<double>()));
  }
  return folder / "model.rom.h5";
}

/// A run of the worker on one processor.
Command worker(const Settings& settings, const std::vector<std::string>& words) {
  Command command;
  command.words = {(settings.programs / "bench_worker").string()};
  command.words.insert(command.words.end(), words.begin(), words.end());
  command.words.insert(command.words.end(), {"--threads", "1"});
  command.cores = 1;
  return command;
}

/// A time step of the reduced model against one of the full model, on the same load.
void compare_steps(const Settings& settings, const std::filesystem::path& model, const std::string& load,
                   Report& report) {
  const int steps = 2 * settings.steps;
  const Command command = worker(
      settings, {"steps", "--case", settings.case_path.string(), "--size", settings.size, "--folder",
                 settings.work.string(), "--model", model.string(), "--load", load, "--steps", std::to_string(steps)});
  std::vector<double> reduced, full;
  Outcome last;
  for (int i = 0; i < settings.pairs; ++i) {
    last = run(command);
    reduced.push_back(last["reduced"]);
    full.push_back(last["full"]);
  }
  report.compare(fmt::format("step of {}, order {}", load, last["order"]), reduced, full,
                 fmt::format("full model, {} unknowns", last["unknowns"]), 1, last.peak_MiB, 0);
  if (load == "air_cutting") report.figure("TCP error at a pose", duration(last["tcp"]), 1);
  report.note(
      fmt::format("{}: sensors of both models {:.1e} K apart after {} steps", load, last["sensors_apart_K"], steps));
}

/// A step of the compensator, with films that stand or change. @param order  0: all of the model
void compare_online(const Settings& settings, const std::filesystem::path& model, int order, Report& report) {
  const Command command = worker(settings, {"online", "--model", model.string(), "--order", std::to_string(order),
                                            "--steps", std::to_string(online_steps)});
  std::map<std::string, std::vector<double>> times;
  Outcome last;
  for (int i = 0; i < settings.pairs; ++i) {
    last = run(command);
    for (const char* name : {"fixed", "three", "all", "plain"}) times[name].push_back(last[name]);
  }
  const std::string alternative =
      fmt::format("summed, factorised, solved each step ({} outputs as ours)", last["outputs"]);
  for (const auto& [name, what] : {std::pair<std::string, std::string>{"fixed", "films stand"},
                                   {"three", "three films change"},
                                   {"all", fmt::format("all {} films change", last["films"])}}) {
    report.compare(fmt::format("online step, order {}: {}", last["order"], what), times[name], times["plain"],
                   alternative, 1);
    report.note(
        fmt::format("order {}, {}: 99.9 % of the steps within {}", last["order"], what, duration(last[name + "_999"])));
  }
}

}  // namespace

std::filesystem::path model_of(const Settings& settings) {
  if (!settings.model.empty()) return settings.model;
  const auto folder = settings.work / ("reduced_" + settings.size);
  if (!std::filesystem::exists(folder / "model.rom.h5")) run(reduce(settings, folder, true));
  return folder / "model.rom.h5";
}

std::string reduction_subject(const Settings& settings) {
  Report report("reduction, " + settings.size);
  const auto model = settings.model.empty() ? measure_making(settings, report) : settings.model;
  for (const std::string load : {"validation_21C", "air_cutting"}) compare_steps(settings, model, load, report);
  for (const int order : {60, 0}) compare_online(settings, model, order, report);
  report.note("steps: one processor, its time; campaign and reduction: wall time");
  return report.text();
}

}  // namespace thermotwin::bench
