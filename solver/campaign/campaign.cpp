// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/error.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/adaptive_simulation.h"
#include "solver/campaign/files.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/campaign/radiation_check.h"
#include "solver/campaign/recorder.h"
#include "solver/elastic/tcp.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::solver {
namespace {

using Block = std::vector<const LoadProgram*>;

/// Of the iteration. Tables of a campaign then agree with those of other runs of its loads within 1e-9.
constexpr double residual_tolerance = 1e-11;

std::filesystem::path checkpoint_path(const CampaignOptions& options, const std::string& first_load) {
  return options.checkpoints / ("checkpoint_" + first_load + ".bin");
}

std::string block_hash(const std::vector<std::string>& loads, const std::map<std::string, std::string>& hashes,
                       const CampaignOptions& options) {
  std::vector<std::string> of_loads{options.keep_snapshots ? "with snapshots" : ""};
  if (options.field_modes > 0) of_loads.push_back(fmt::format("{} field modes", options.field_modes));
  for (const std::string& load : loads) of_loads.push_back(hashes.at(load));
  return hash_of_block(of_loads);
}

std::vector<std::string> names(const Block& block) {
  std::vector<std::string> result;
  for (const LoadProgram* load : block) result.push_back(load->name());
  return result;
}

/// Loads that a stopped campaign ran together, to go on together: their bits depend on each other.
std::vector<Block> stopped_blocks(const std::vector<LoadProgram>& loads,
                                  const std::map<std::string, std::string>& hashes, const CampaignOptions& options) {
  std::vector<std::filesystem::path> files;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(options.checkpoints, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool is_whole = name.find(".part-") == std::string::npos;  // the other is left by a program that was killed
    if (name.starts_with("checkpoint_") && entry.path().extension() == ".bin" && is_whole)
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Block> blocks;
  for (const std::filesystem::path& file : files) {
    const auto owner = Checkpoint::owner(file);
    Block block;
    if (owner) {
      for (const std::string& member : owner->members) {
        for (const LoadProgram& load : loads)
          if (load.name() == member) block.push_back(&load);
      }
    }
    // One of loads that are not asked for now is none of our business.
    if (owner && block.empty()) continue;
    if (!owner || block.size() != owner->members.size() || block_hash(owner->members, hashes, options) != owner->hash ||
        checkpoint_path(options, owner->members.front()) != file) {
      core::warn(file.string() + " is damaged, or belongs to another machine, mesh, load or options; it is not used");
      continue;
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

/// Runs loads of one time grid; their results are written as soon as they are complete, so that a
/// stopped campaign keeps them.
std::vector<LoadResult> run_block(const FullModel& model, const OperatingModel& operating, const Block& block,
                                  const std::vector<mesh::Pose>& poses, const Eigen::MatrixXd& rows,
                                  const std::map<std::string, std::string>& hashes, RadiationCheck& radiation,
                                  const CampaignOptions& options) {
  std::optional<Checkpoint> checkpoint;
  if (!options.checkpoints.empty()) {
    checkpoint.emplace(checkpoint_path(options, block.front()->name()), block_hash(names(block), hashes, options),
                       names(block), options.checkpoint_s, options.resume);
  }
  std::vector<HeatBalance> balances(block.size(), HeatBalance(model.mesh.machine, model.thermal));
  std::vector<Recorder> recorders;
  recorders.reserve(block.size());
  for (const LoadProgram* load : block) {
    recorders.emplace_back(model, *load, poses, operating.channels(), balances.front(), options,
                           checkpoint ? options.checkpoints : std::filesystem::path());
  }
  if (checkpoint) {
    checkpoint->save_rest = [&](core::BinaryWriter& out) {
      for (Recorder& recorder : recorders) recorder.save(out);
    };
    checkpoint->load_rest = [&](core::BinaryReader& in) {
      for (Recorder& recorder : recorders) recorder.load(in);
    };
  }
  SimulationOptions simulation;
  simulation.balances = &balances;
  simulation.refine = options.refine;
  simulation.start = options.start;
  simulation.checkpoint = checkpoint ? &*checkpoint : nullptr;
  const auto record = [&](const OutputState& output) {
    recorders[output.load].add(output, rows, balances[output.load]);
    radiation.add(operating, block[output.load]->name(), output);
    if (options.on_output) options.on_output(*block[output.load], output);
  };
  RunSummary summary;
  const TimeScheme scheme = block.front()->time().scheme;
  if (scheme == TimeScheme::adaptive) {
    AdaptiveIntegrator integrator(model.thermal);
    summary = simulate_adaptive(integrator, operating, *block.front(), simulation, record);
  } else {
    IntegratorOptions integrator_options;
    integrator_options.keep_mean = true;
    integrator_options.tolerance = residual_tolerance;
    integrator_options.backward_euler = scheme == TimeScheme::backward_euler;
    ThermalIntegrator integrator(model.thermal, integrator_options);
    summary = simulate(integrator, operating, block, simulation, record);
    summary.factorisations = integrator.statistics().factorisations;
    summary.iterations = integrator.statistics().iterations;
  }
  std::vector<LoadResult> results;
  for (std::size_t l = 0; l < block.size(); ++l) {
    LoadResult result = recorders[l].take();
    result.run = summary;
    result.heat = balances[l];
    if (!options.out.empty()) write_result(options.out / result.load, result, hashes.at(result.load));
    results.push_back(std::move(result));
  }
  if (checkpoint) checkpoint->remove();
  for (const Recorder& recorder : recorders) recorder.discard_spool();
  return results;
}

/// Says which loads of --resume run again though there is a result. @param loads  names, by the reason
void say_unused(const std::map<Unused, std::string>& loads, const std::filesystem::path& folder) {
  const auto say = [&](Unused why, const char* reason, const auto& line) {
    if (const auto found = loads.find(why); found != loads.end())
      line(fmt::format("{}: results of {} {}; the run starts anew", folder.string(), found->second, reason));
  };
  const auto warn = [](const std::string& text) { core::warn(text); };
  say(Unused::other_inputs, "belong to another machine, mesh, load or options", warn);
  say(Unused::changed_tables, "were changed by hand or are damaged", warn);
  say(Unused::no_temperatures, "have no temperatures of the nodes, which are needed here", core::log_line);
}

}  // namespace

void CampaignOptions::validate() const {
  const std::string of = "campaign options: ";
  core::require_within(of + "refine", refine, core::positive);
  core::require_within(of + "field_modes", field_modes, core::non_negative);
  core::require_within(of + "checkpoint_s", checkpoint_s, core::non_negative);
  for (const mesh::Pose& pose : poses)
    if (!pose.allFinite()) throw core::InputError(of + "poses", "a position that is not a number", "finite positions");
  if (!start.allFinite()) throw core::InputError(of + "start", "a temperature that is not a number", "finite values");
  if (time) time->validate();
}

// One thermal run a load: the machine moves as its program says, and the temperature that this
// leaves is the same for all poses, which are where its error is read.
std::vector<LoadResult> run_campaign(const FullModel& model, const std::vector<LoadProgram>& programs,
                                     const CampaignOptions& options) {
  options.validate();
  if (!options.out.empty() && !model.mesh.machine.has_tcp()) {
    throw core::InputError(model.mesh.machine.path.string() + " [tcp]", "missing",
                           "a [tcp]: the tables of a campaign hold its error");
  }
  std::vector<LoadProgram> loads = programs;
  if (options.time)
    for (LoadProgram& load : loads) load.set_time(*options.time);
  const std::vector<mesh::Pose> poses =
      options.poses.empty() ? mesh::workspace_poses(model.mesh.machine) : options.poses;
  std::map<std::string, LoadResult> finished;
  std::map<std::string, std::string> hashes;
  if (!options.out.empty() || !options.checkpoints.empty()) {
    const std::string mesh_hash = hash_of_mesh(model.mesh);
    for (const LoadProgram& load : loads) hashes[load.name()] = hash_of_load(model, mesh_hash, load, poses, options);
  }
  std::vector<Block> blocks;
  if (options.resume && !options.checkpoints.empty()) blocks = stopped_blocks(loads, hashes, options);
  std::set<std::string> placed;
  for (const Block& block : blocks)
    for (const LoadProgram* load : block) placed.insert(load->name());
  std::vector<LoadProgram> open;
  std::map<Unused, std::string> unused;
  for (const LoadProgram& load : loads) {
    if (placed.contains(load.name())) continue;
    if (!options.out.empty() && options.resume) {
      if (auto result = read_result(options.out / load.name(), load.name(), hashes[load.name()], options)) {
        core::remove_stale_lock(options.out / load.name());
        finished.emplace(load.name(), std::move(*result));
        continue;
      }
      std::string& names = unused[why_unused(options.out / load.name(), hashes[load.name()])];
      names += (names.empty() ? "" : ", ") + load.name();
    }
    open.push_back(load);
  }
  say_unused(unused, options.out);
  for (Block& block : blocks_of_equal_grid(open, options.refine)) blocks.push_back(std::move(block));
  std::vector<core::FolderLock> locks;  // of all that will be written: refused before anything is computed
  if (!options.out.empty()) {
    for (const Block& block : blocks)
      for (const LoadProgram* load : block) locks.emplace_back(options.out / load->name());
  }

  if (!blocks.empty()) {
    const Eigen::MatrixXd rows = stacked_rows(model, poses);
    const OperatingModel operating(model.mesh.machine, model.thermal.layout);
    RadiationCheck radiation(model.mesh.machine, model.thermal);
    for (const Block& block : blocks) {
      for (LoadResult& result : run_block(model, operating, block, poses, rows, hashes, radiation, options)) {
        const std::string name = result.load;
        finished.emplace(name, std::move(result));
      }
    }
    if (const std::string warning = radiation.warning(); !warning.empty()) core::warn(warning);
  }
  std::vector<LoadResult> results;
  for (const LoadProgram& load : loads) results.push_back(std::move(finished.at(load.name())));
  return results;
}

}  // namespace thermotwin::solver
