// SPDX-License-Identifier: GPL-3.0-or-later
// Load programs on the reduced model: the same files as the full model's campaign, in a moment, with an
// estimate of their error.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/thread_pool.h"
#include "reduction/error_estimate.h"
#include "reduction/model_file.h"
#include "reduction/reduce.h"
#include "tools/chain.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  double peak_um = 0, estimate_um = 0, seconds = 0;
  std::size_t times = 0;
};

void write_load(const fs::path& folder, const solver::LoadResult& result, const core::Table* estimate) {
  core::write_files_by(folder, [&](const fs::path& staged) {
    std::vector<fs::path> files{"tcp.csv", "sensors.csv", "inputs.csv"};
    const core::Table* tables[] = {&result.tcp, &result.sensors, &result.inputs};
    for (std::size_t i = 0; i < files.size(); ++i) core::write_csv(staged / files[i], *tables[i]);
    if (estimate) {
      files.emplace_back("error_estimate.csv");
      core::write_csv(staged / files.back(), *estimate);
    }
    return files;
  });
}

}  // namespace

void reduced_campaign(const CampaignOptions& options) {
  const Stopwatch time;
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  const fs::path file = options.model.empty() ? options.out / "model.rom.h5" : options.model;
  const reduction::ReducedModel model = model_for(options.case_path, file, options.out);
  const fs::path beside = file.parent_path() / "reference.rom.h5";
  fs::path reference_file = options.reference;
  if (reference_file.empty() && fs::exists(beside)) reference_file = beside;
  std::optional<reduction::ReducedModel> reference;
  if (!reference_file.empty()) reference = reduction::read_model(reference_file);

  std::vector<std::string> names = options.loads;
  if (names.empty()) {
    names = machine_case.train;
    names.insert(names.end(), machine_case.holdout.begin(), machine_case.holdout.end());
  }
  const auto programs = load_programs(machine_case, names);
  require_writable(options.out);
  reduction::ReducedRun how;
  how.exact = options.exact;
  const auto poses = mesh::workspace_poses(machine_case.machine);
  const fs::path folder = options.out / "campaign";
  std::vector<Outcome> outcomes(programs.size());
  core::Progress progress("reduced runs", programs.size());
  core::parallel_for(0, programs.size(), [&](std::size_t i) {
    const Stopwatch watch;
    Outcome& outcome = outcomes[i];
    solver::LoadResult result;
    if (reference) {
      reduction::EstimatedRun run = reduction::simulate_with_estimate(model, *reference, machine_case.machine, programs[i], poses, how);
      outcome.estimate_um = reduction::largest_translation(run.estimate);
      outcome.seconds = watch.seconds();
      write_load(folder / programs[i].name(), run.result, &run.estimate);
      result = std::move(run.result);
    } else {
      result = reduction::simulate_reduced(model, machine_case.machine, programs[i], poses, how);
      outcome.seconds = watch.seconds();
      write_load(folder / programs[i].name(), result, nullptr);
    }
    outcome.peak_um = reduction::largest_translation(result.tcp);
    outcome.times = static_cast<std::size_t>(result.sensors.rows());
    progress.advance();
  });

  std::vector<std::vector<std::string>> table{{"load", "times", "poses", "largest TCP error um", "estimated error um", "s"}};
  nlohmann::json json = {{"order", model.system.order()}, {"seconds", time.seconds()}};
  if (reference) json["reference_order"] = reference->system.order();
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const Outcome& o = outcomes[i];
    table.push_back({programs[i].name(), std::to_string(o.times), std::to_string(poses.size()), fmt::format("{:.2f}", o.peak_um),
                     reference ? fmt::format("{:.3f}", o.estimate_um) : "-", fmt::format("{:.3f}", o.seconds)});
    json["loads"].push_back({{"load", programs[i].name()}, {"times", o.times}, {"poses", poses.size()}, {"peak_um", o.peak_um}, {"seconds", o.seconds}});
    if (reference) json["loads"].back()["estimate_um"] = o.estimate_um;
  }
  print_summary(options, fmt::format("{}\norder {}{}, {:.1f} s; tables in {}\n", core::format_table(table), model.system.order(),
                                     reference ? fmt::format(", estimates by order {}", reference->system.order()) : "", time.seconds(), folder.string()),
                json.dump());
}

}  // namespace thermotwin::tools
