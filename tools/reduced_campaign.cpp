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
#include "mesh/machine/kinematics.h"
#include "reduction/basis/error_estimate.h"
#include "reduction/basis/reduce.h"
#include "reduction/bound/error_bound.h"
#include "reduction/bound/file.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "reduction/systems/campaign_tables.h"
#include "solver/campaign/case.h"
#include "solver/campaign/load_result.h"
#include "tools/chain.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  double peak_um = 0, estimate_um = 0, bound_um = 0, seconds = 0;
  std::optional<double> estimate_there_um;  ///< at the bound's poses; nothing where the workspace grid has none of them
  std::size_t times = 0;
};

void write_load(const fs::path& folder, const solver::LoadResult& result, const core::Table* estimate,
                const core::Table* bound, const std::string& maker) {
  core::write_files_by(folder, [&](const fs::path& staged) {
    std::vector<fs::path> files{"tcp.csv", "sensors.csv", "inputs.csv"};
    const core::Table* tables[] = {&result.tcp, &result.sensors, &result.inputs};
    for (std::size_t i = 0; i < files.size(); ++i) core::write_csv(staged / files[i], *tables[i]);
    if (estimate) {
      files.emplace_back("error_estimate.csv");
      core::write_csv(staged / files.back(), *estimate);
    }
    if (bound) {
      files.emplace_back("error_bound.csv");
      core::write_csv(staged / files.back(), *bound);
    }
    files.emplace_back(reduction::made_by_file);
    core::write_file(staged / files.back(), maker);
    return files;
  });
}

std::string poses_text(const mesh::Machine& machine, const std::vector<mesh::Pose>& poses) {
  if (machine.axes.empty()) return "the only pose";
  std::string text;
  for (const mesh::Pose& pose : poses) text += (text.empty() ? "" : " and ") + mesh::format_pose(machine, pose);
  return text;
}

/// Rows of a table at these poses, if it has any of them; `all` are its poses at each time.
std::optional<core::Table> at_poses(const core::Table& table, const std::vector<mesh::Pose>& all,
                                    const std::vector<mesh::Pose>& wanted) {
  core::Table part{table.source, table.columns, {}};
  std::vector<Eigen::Index> rows;
  for (const mesh::Pose& pose : wanted) {
    const std::vector<Eigen::Index> more = rows_at(all, pose, table.rows());
    rows.insert(rows.end(), more.begin(), more.end());
  }
  if (rows.empty()) return std::nullopt;
  part.values = table.values(rows, Eigen::all);
  return part;
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

  std::optional<reduction::BoundModel> bound;
  if (options.bound) {
    if (options.exact)
      throw core::UsageError("campaign: --bound is for the full model's time scheme, --exact has another");
    bound = reduction::read_bound(file.parent_path() / "bound.rom.h5", model);
    tell_what_no_bound_covers(machine_case.machine);
  }

  std::vector<std::string> names = options.loads;
  if (names.empty()) {
    names = machine_case.train;
    names.insert(names.end(), machine_case.holdout.begin(), machine_case.holdout.end());
  }
  const auto programs = load_programs(machine_case, names);
  require_writable(options.out);
  reduction::ReducedRun run;
  run.exact = options.exact;
  const auto poses = mesh::workspace_poses(machine_case.machine);
  const fs::path folder =
      options.out / "campaign_reduced";  // campaign/ holds the full model's tables, which resumed runs trust
  const std::string maker =
      fmt::format("reduced model of order {}, {}\n", model.system.order(), file.filename().string());
  std::vector<Outcome> outcomes(programs.size());
  core::Progress progress("reduced runs", programs.size());
  core::parallel_for(0, programs.size(), [&](std::size_t i) {
    const Stopwatch watch;
    Outcome& outcome = outcomes[i];
    solver::LoadResult result;
    reduction::RunRecord record;
    reduction::ReducedRun how = run;
    if (bound) how.record = &record;
    std::optional<reduction::ErrorBound> bounded;
    const auto bound_it = [&] {
      if (!bound) return static_cast<const core::Table*>(nullptr);
      bounded = reduction::error_bound(model, *bound, machine_case.machine, record);
      outcome.bound_um = bounded->largest_um;
      return static_cast<const core::Table*>(&bounded->table);
    };
    if (reference) {
      reduction::EstimatedRun estimated =
          reduction::simulate_with_estimate(model, *reference, machine_case.machine, programs[i], poses, how);
      outcome.estimate_um = reduction::largest_translation(estimated.estimate);
      if (bound) {
        const auto there = at_poses(estimated.estimate, poses, bound->poses);
        if (there) outcome.estimate_there_um = reduction::largest_translation(*there);
      }
      const core::Table* limits = bound_it();
      outcome.seconds = watch.seconds();
      write_load(folder / programs[i].name(), estimated.result, &estimated.estimate, limits, maker);
      result = std::move(estimated.result);
    } else {
      result = reduction::simulate_reduced(model, machine_case.machine, programs[i], poses, how);
      const core::Table* limits = bound_it();
      outcome.seconds = watch.seconds();
      write_load(folder / programs[i].name(), result, nullptr, limits, maker);
    }
    outcome.peak_um = reduction::largest_translation(result.tcp);
    outcome.times = result.sensors.rows();
    progress.advance();
  });

  std::vector<std::vector<std::string>> table{{"load", "times", "poses", "largest TCP error um", "estimated error um"}};
  if (bound) table[0].insert(table[0].end(), {"at the bound's poses um", "bound there um"});
  table[0].emplace_back("s");
  nlohmann::json json = {{"order", model.system.order()}, {"seconds", time.seconds()}};
  if (reference) json["reference_order"] = reference->system.order();
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const Outcome& o = outcomes[i];
    table.push_back({programs[i].name(), std::to_string(o.times), std::to_string(poses.size()),
                     fmt::format("{:.2f}", o.peak_um), reference ? fmt::format("{:.3f}", o.estimate_um) : "-"});
    if (bound) {
      table.back().push_back(o.estimate_there_um ? fmt::format("{:.3f}", *o.estimate_there_um) : "-");
      table.back().push_back(fmt::format("{:.3f}", o.bound_um));
    }
    table.back().push_back(fmt::format("{:.3f}", o.seconds));
    json["loads"].push_back({{"load", programs[i].name()},
                             {"times", o.times},
                             {"poses", poses.size()},
                             {"peak_um", o.peak_um},
                             {"seconds", o.seconds}});
    if (reference) json["loads"].back()["estimate_um"] = o.estimate_um;
    if (bound) json["loads"].back()["bound_um"] = o.bound_um;
    if (o.estimate_there_um) json["loads"].back()["estimate_at_bound_poses_um"] = *o.estimate_there_um;
  }
  print_summary(
      options,
      fmt::format("{}\norder {}{}{}, {:.1f} s; tables in {}\n", core::format_table(table), model.system.order(),
                  reference ? fmt::format(", estimates by order {}", reference->system.order()) : "",
                  bound ? fmt::format(", bounds at {} by order {}", poses_text(machine_case.machine, bound->poses),
                                      bound->terms.order())
                        : "",
                  time.seconds(), folder.string()),
      json.dump());
}

}  // namespace thermotwin::tools
