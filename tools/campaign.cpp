// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/campaign.h"

#include <fmt/format.h>

#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/error_estimate.h"
#include "solver/campaign/load_fields.h"
#include "solver/export/machine_scene.h"
#include "tools/campaign_page.h"
#include "tools/page.h"

namespace thermotwin::tools {

std::vector<solver::LoadProgram> campaign_programs(const CampaignOptions& options, const solver::Case& machine_case) {
  std::vector<std::string> names = options.loads;
  if (names.empty()) {
    names = machine_case.train;
    names.insert(names.end(), machine_case.holdout.begin(), machine_case.holdout.end());
  }
  return load_programs(machine_case, names);
}

solver::CampaignOptions campaign_settings(const CampaignOptions& options, const std::filesystem::path& folder) {
  solver::CampaignOptions settings;
  settings.out = settings.checkpoints = folder;
  settings.resume = options.resume;
  settings.checkpoint_s = options.checkpoint_every_s;
  settings.field_modes = solver::scene_modes;
  return settings;
}

CampaignSummary present_campaign(const CampaignOptions& options, const std::vector<solver::LoadProgram>& programs,
                                 const solver::FullModel& full, const std::vector<solver::LoadResult>& results,
                                 const Stopwatch& time) {
  const std::filesystem::path folder = options.out / "campaign";
  std::vector<std::vector<std::string>> table{{"load", "times", "poses", "largest TCP error um"}};
  nlohmann::json json = {{"nodes", full.mesh.nodes()}, {"seconds", time.seconds()}, {"peak_GiB", peak_memory_GiB()}};
  const std::size_t poses = mesh::workspace_poses(full.mesh.machine).size();
  for (const solver::LoadResult& result : results) {
    const double peak = reduction::compare(result, result).peak_um;
    table.push_back(
        {result.load, std::to_string(result.sensors.rows()), std::to_string(poses), fmt::format("{:.2f}", peak)});
    json["loads"].push_back(
        {{"load", result.load}, {"times", result.sensors.rows()}, {"poses", poses}, {"peak_um", peak}});
  }
  write_page(folder / "report.html", [&] {
    std::vector<const solver::LoadFields*> of_loads;
    for (const solver::LoadResult& result : results) of_loads.push_back(&result.fields);
    const solver::CommonFields fields = solver::in_common(of_loads, full.thermal.size, solver::scene_modes);
    solver::MachineScene scene = solver::make_scene(full, fields.modes);
    for (std::size_t l = 0; l < results.size(); ++l) {
      scene.loads.push_back(
          solver::scene_load(results[l].load, results[l].tcp, std::ssize(scene.poses), fields.coefficients[l]));
    }
    return campaign_page({options, fmt::format("{} nodes", full.mesh.nodes()), programs, scene, table, &full});
  });
  return {fmt::format("{}\n{} nodes, {:.0f} s; tables and report.html in {}\n", core::format_table(table),
                      full.mesh.nodes(), time.seconds(), folder.string()),
          json};
}

void campaign(const CampaignOptions& options) {
  if (options.reduced) return reduced_campaign(options);
  const Stopwatch time;
  const solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order);
  const std::vector<solver::LoadProgram> programs = campaign_programs(options, machine_case);
  const solver::FullModel full = build(machine_case, options.out, options.solver);
  const auto results = solver::run_campaign(full, programs, campaign_settings(options, options.out / "campaign"));
  const CampaignSummary summary = present_campaign(options, programs, full, results, time);
  print_summary(options, summary.text, summary.json.dump());
}

}  // namespace thermotwin::tools
