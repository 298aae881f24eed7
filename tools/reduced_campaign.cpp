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
#include "solver/campaign/files.h"
#include "solver/campaign/load_result.h"
#include "tools/campaign_page.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/reduced_scene.h"

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
    for (std::size_t i = 0; i < files.size(); ++i) core::write_csv(staged / files[i], *tables[i], solver::table_digits);
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

/// The workspace grid, the same at all positions of the table's axes, or the poses asked for.
std::vector<mesh::Pose> poses_of(const mesh::Machine& machine, const CampaignOptions& options) {
  std::vector<mesh::Pose> poses;
  for (const std::string& text : options.poses) poses.push_back(mesh::parse_pose(machine, text, "--pose"));
  if (!poses.empty()) return poses;
  poses = mesh::workspace_poses(machine);
  if (!options.all_tilts) return poses;
  for (std::size_t i = 0; i < machine.workspace.table_axes.size(); ++i) {
    const int axis = machine.axis_index(machine.workspace.table_axes[i]);
    std::vector<mesh::Pose> turned;
    for (const double position : machine.workspace.table_positions[i]) {
      for (mesh::Pose pose : poses) {
        pose[axis] = position;
        turned.push_back(pose);
      }
    }
    poses = std::move(turned);
  }
  return poses;
}

/// All that the runs of a campaign share.
struct Runs {
  solver::Case machine_case;
  reduction::ReducedModel model;
  std::optional<reduction::ReducedModel> reference;
  std::optional<reduction::BoundModel> bound;
  std::vector<mesh::Pose> poses;
  reduction::ReducedRun how;
  std::string maker;
};

Runs read_runs(const CampaignOptions& options) {
  const fs::path file = options.model.empty() ? options.out / "model.rom.h5" : options.model;
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  Runs runs{machine_case, model_for(options.case_path, file, options.out), {}, {}, {}, {}, {}};
  const fs::path beside = file.parent_path() / "reference.rom.h5";
  fs::path reference_file = options.reference;
  if (reference_file.empty() && fs::exists(beside)) reference_file = beside;
  if (!reference_file.empty()) runs.reference = reduction::read_model(reference_file);
  if (options.bound) {
    if (options.exact)
      throw core::UsageError("campaign: --bound holds for the full model's time scheme and excludes --exact");
    runs.bound = reduction::read_bound(file.parent_path() / "bound.rom.h5", runs.model);
    tell_what_no_bound_covers(machine_case.machine);
  }
  runs.poses = poses_of(machine_case.machine, options);
  runs.how.exact = options.exact;
  runs.maker = fmt::format("reduced model of order {}, {}\n", runs.model.system.order(), file.filename().string());
  return runs;
}

Outcome run_load(const Runs& runs, const solver::LoadProgram& program, const fs::path& folder) {
  const Stopwatch watch;
  const mesh::Machine& machine = runs.machine_case.machine;
  Outcome outcome;
  reduction::RunRecord record;
  reduction::ReducedRun how = runs.how;
  if (runs.bound) how.record = &record;
  solver::LoadResult result;
  std::optional<core::Table> estimate, limits;
  if (runs.reference) {
    reduction::EstimatedRun estimated =
        reduction::simulate_with_estimate(runs.model, *runs.reference, machine, program, runs.poses, how);
    result = std::move(estimated.result);
    estimate = std::move(estimated.estimate);
    outcome.estimate_um = reduction::largest_translation(*estimate);
    const auto there = runs.bound ? at_poses(*estimate, runs.poses, runs.bound->poses) : std::nullopt;
    if (there) outcome.estimate_there_um = reduction::largest_translation(*there);
  } else {
    result = reduction::simulate_reduced(runs.model, machine, program, runs.poses, how);
  }
  if (runs.bound) {
    reduction::ErrorBound bounded = reduction::error_bound(runs.model, *runs.bound, machine, record);
    outcome.bound_um = bounded.largest_um;
    limits = std::move(bounded.table);
  }
  outcome.seconds = watch.seconds();
  write_load(folder / program.name(), result, estimate ? &*estimate : nullptr, limits ? &*limits : nullptr, runs.maker);
  outcome.peak_um = reduction::largest_translation(result.tcp);
  outcome.times = result.sensors.rows();
  return outcome;
}

std::vector<std::vector<std::string>> table_of(const Runs& runs, const std::vector<solver::LoadProgram>& programs,
                                               const std::vector<Outcome>& outcomes) {
  std::vector<std::vector<std::string>> table{{"load", "times", "poses", "largest TCP error um", "estimated error um"}};
  if (runs.bound) table[0].insert(table[0].end(), {"estimated at the bound's poses um", "bound there um"});
  table[0].emplace_back("s");
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const Outcome& o = outcomes[i];
    table.push_back({programs[i].name(), std::to_string(o.times), std::to_string(runs.poses.size()),
                     fmt::format("{:.2f}", o.peak_um), runs.reference ? fmt::format("{:.3f}", o.estimate_um) : "-"});
    if (runs.bound) {
      table.back().push_back(o.estimate_there_um ? fmt::format("{:.3f}", *o.estimate_there_um) : "-");
      table.back().push_back(fmt::format("{:.3f}", o.bound_um));
    }
    table.back().push_back(fmt::format("{:.3f}", o.seconds));
  }
  return table;
}

nlohmann::json json_of(const Runs& runs, const std::vector<solver::LoadProgram>& programs,
                       const std::vector<Outcome>& outcomes) {
  nlohmann::json json = {{"order", runs.model.system.order()}};
  if (runs.reference) json["reference_order"] = runs.reference->system.order();
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const Outcome& o = outcomes[i];
    nlohmann::json load = {{"load", programs[i].name()},
                           {"times", o.times},
                           {"poses", runs.poses.size()},
                           {"peak_um", o.peak_um},
                           {"seconds", o.seconds}};
    if (runs.reference) load["estimate_um"] = o.estimate_um;
    if (runs.bound) load["bound_um"] = o.bound_um;
    if (o.estimate_there_um) load["estimate_at_bound_poses_um"] = *o.estimate_there_um;
    json["loads"].push_back(std::move(load));
  }
  return json;
}

}  // namespace

void reduced_campaign(const CampaignOptions& options) {
  const Stopwatch time;
  const Runs runs = read_runs(options);
  std::vector<std::string> names = options.loads;
  if (names.empty()) {
    names = runs.machine_case.train;
    names.insert(names.end(), runs.machine_case.holdout.begin(), runs.machine_case.holdout.end());
  }
  const auto programs = load_programs(runs.machine_case, names);
  require_writable(options.out);
  // campaign/ holds the full model's tables, which resumed runs trust.
  const fs::path folder = options.out / "campaign_reduced";
  std::vector<Outcome> outcomes(programs.size());
  core::Progress progress("reduced runs", programs.size());
  core::parallel_for(0, programs.size(), [&](std::size_t i) {
    outcomes[i] = run_load(runs, programs[i], folder);
    progress.advance();
  });

  nlohmann::json json = json_of(runs, programs, outcomes);
  json["seconds"] = time.seconds();
  const auto& [machine_case, model, reference, bound, poses, how, maker] = runs;
  const std::vector<std::vector<std::string>> table = table_of(runs, programs, outcomes);
  write_page(folder / "report.html", [&] {
    const fs::path beside = (options.model.empty() ? options.out / "model.rom.h5" : options.model).parent_path();
    const solver::MachineScene scene = reduced_scene(beside / "scene.bin", runs.model, programs);
    return campaign_page({options, fmt::format("order {}", runs.model.system.order()), programs, scene, table});
  });
  print_summary(options,
                fmt::format("{}\norder {}{}{}, {:.1f} s; tables and report.html in {}\n", core::format_table(table),
                            model.system.order(),
                            reference ? fmt::format(", estimates by order {}", reference->system.order()) : "",
                            bound ? fmt::format(", bounds at {} by order {}",
                                                poses_text(machine_case.machine, bound->poses), bound->terms.order())
                                  : "",
                            time.seconds(), folder.string()),
                json.dump());
}

}  // namespace thermotwin::tools
