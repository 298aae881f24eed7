// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that computes a campaign in units. A unit is the load programs that run side by side, because their bits
// depend on each other; so the gathered files are those of `campaign`.

#include "solver/campaign/campaign.h"

#include <fmt/format.h>

#include <exception>
#include <memory>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/quoted.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "solver/campaign/files.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/tcp.h"
#include "study/units/resources.h"
#include "tools/campaign.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/study/cluster.h"
#include "tools/study/study.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using Blocks = std::vector<std::vector<const solver::LoadProgram*>>;

std::vector<study::Unit> campaign_units(const StudyCampaignOptions& options, const solver::Case& machine_case,
                                        const Blocks& blocks) {
  const std::string of_case = study::hash_of_case(
      machine_case, fmt::format("campaign 1 {} {} {}", THERMOTWIN_VERSION, machine_case.size, options.solver));
  std::vector<study::Unit> units;
  for (const auto& block : blocks) {
    std::string inputs = of_case;
    std::vector<std::string> names;
    for (const solver::LoadProgram* load : block) {
      inputs += " " + study::words_of_load(machine_case, load->name());
      names.push_back("'" + load->name() + "'");
    }
    units.push_back({core::content_hash(inputs), "load programs " + core::join(names)});
  }
  return units;
}

class CampaignStudy {
public:
  explicit CampaignStudy(const StudyCampaignOptions& options)
      : options_(options),
        machine_case_(open_case(options.case_path, options.size, options.mesh_order)),
        programs_(campaign_programs(options, machine_case_)),
        blocks_(solver::blocks_of_equal_grid(programs_)) {
    study_.origin = machine_case_.folder;
    study_.folder = options.out / "study" / "campaign";
    study_.units = campaign_units(options, machine_case_, blocks_);
    study_.command = words();
    study_.compute = [this](std::size_t unit, const fs::path& folder) { return compute(unit, folder); };
    study_.disk_bytes = [this](std::size_t unit) { return disk_bytes(unit); };
    study_.memory = [this](const std::vector<std::size_t>&) {
      const mesh::Machine& machine = machine_case_.machine;
      const Eigen::Index nodes =
          study::nodes_of_mesh(machine, mesh::size_factor(machine, machine_case_.size), options_.out / "cache");
      return study::MemoryWanted{study::model_bytes(nodes), fmt::format("{} nodes", nodes),
                                 "more memory, or a coarser --size"};
    };
    study_.gather = [this](const study::Work& work) { gather(work); };
  }

  void carry_out() {
    open_study(options_.cluster, study_.folder, machine_case_.folder);
    tools::carry_out(options_, options_.cluster, study_);
  }

private:
  std::string words() const {
    std::string words =
        fmt::format("study campaign {} --checkpoint-every {:g}{}", core::shell_word(fs::absolute(options_.case_path)),
                    options_.checkpoint_every_s, mesh_words(options_.size, options_.mesh_order, options_.solver));
    for (const std::string& load : options_.loads) words += " --load " + core::shell_word(load);
    return words;
  }

  /// Tables in the unit's folder, and their copies in campaign/.
  double disk_bytes(std::size_t unit) const {
    const mesh::Machine& machine = machine_case_.machine;
    const double poses = mesh::workspace_poses(machine).size();
    const double per_pose = 1 + machine.axes.size() + solver::tcp_columns().size();
    const double others = 1 + machine.sensors.size();
    double bytes = 0;
    for (const solver::LoadProgram* load : blocks_[unit])
      bytes += 2.0 * study::table_bytes(load->output_times().size() * (poses * per_pose + others));
    return bytes;
  }

  /// Units share one attempt to make it.
  const solver::FullModel& full() {
    if (hopeless_) std::rethrow_exception(hopeless_);
    try {
      if (!full_) full_ = std::make_unique<solver::FullModel>(build(machine_case_, options_.out, options_.solver));
    } catch (const core::Error&) {
      hopeless_ = std::current_exception();
      throw;
    }
    return *full_;
  }

  study::UnitFiles compute(std::size_t unit, const fs::path& folder) {
    std::vector<solver::LoadProgram> block;
    for (const solver::LoadProgram* load : blocks_[unit]) block.push_back(*load);
    solver::CampaignOptions settings = campaign_settings(options_, folder / "campaign");
    settings.resume = true;
    solver::run_campaign(full(), block, settings);
    study::UnitFiles files;
    for (const solver::LoadProgram& load : block)
      for (const fs::path& file : solver::result_files(settings.out / load.name()))
        files.push_back(fs::path("campaign") / load.name() / file);
    return files;
  }

  /// Of the load programs that are done.
  void gather(const study::Work& work) {
    const study::Standing standing = study::standing_of(study_.folder, study_.units);
    write_failures(study_, standing);
    for (const std::size_t u : standing.done) study::publish(study_.folder, study_.units[u], options_.out);
    const solver::CampaignOptions settings = campaign_settings(options_, options_.out / "campaign");
    std::set<std::string> there;
    for (const std::size_t u : standing.done)
      for (const solver::LoadProgram* load : blocks_[u]) there.insert(load->name());
    std::vector<solver::LoadProgram> programs;
    std::vector<solver::LoadResult> results;
    for (const solver::LoadProgram& program : programs_) {
      if (!there.contains(program.name())) continue;
      auto result = solver::read_result(settings.out / program.name(), program.name(), settings);
      if (!result)
        throw core::InputError((settings.out / program.name()).string(), "changed while it was gathered",
                               "one process that writes there");
      programs.push_back(program);
      results.push_back(std::move(*result));
    }
    if (!results.empty()) {
      CampaignSummary summary = present_campaign(options_, programs, full(), results, time_);
      summary.json.update({{"units", study_.units.size()},
                           {"computed", work.computed},
                           {"kept", standing.done.size() - work.computed},
                           {"missing", study::missing_words(study_.units, standing)},
                           {"failed", study::failed_words(study_.units, standing)}});
      print_summary(options_,
                    summary.text + fmt::format("{} units computed, {} done before\n", work.computed,
                                               standing.done.size() - work.computed),
                    summary.json.dump());
    }
    require_none_missing(study_, study::missing_words(study_.units, standing));
    require_none_failed(study_, standing);
  }

  const Stopwatch time_;
  const StudyCampaignOptions& options_;
  const solver::Case machine_case_;
  const std::vector<solver::LoadProgram> programs_;
  const Blocks blocks_;  // of programs_
  UnitStudy study_;
  std::unique_ptr<solver::FullModel> full_;
  std::exception_ptr hopeless_;
};

}  // namespace

void study_campaign(const StudyCampaignOptions& options) {
  study::part_of(options.cluster.part);
  CampaignStudy(options).carry_out();
}

}  // namespace thermotwin::tools
