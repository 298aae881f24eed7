// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/chain.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sys/resource.h>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/error_estimate.h"
#include "reduction/bound/file.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_fields.h"
#include "solver/campaign/load_result.h"
#include "tools/error_tables.h"
#include "tools/second_mesh.h"

namespace thermotwin::tools {

constexpr int off_grid_poses = 12;

void print_summary(const CommonOptions& options, const std::string& text, const std::string& json) {
  std::cout << (options.json ? json : text);
  if (const std::string& shown = options.json ? json : text; shown.empty() || shown.back() != '\n') std::cout << '\n';
  std::cout.flush();
  if (!std::cout) throw core::InputError("standard output", "cannot be written", "a terminal, file or pipe with room");
}

double peak_memory_GiB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / (1024.0 * 1024.0);
}

solver::Case open_case(const std::filesystem::path& path, const std::string& size, int mesh_order, Asked asked) {
  solver::Case machine_case = solver::read_case(path);
  if (asked == Asked::tcp_error && !machine_case.machine.has_tcp()) {
    throw core::InputError(machine_case.machine.path.string() + " [tcp]", "missing",
                           "a [tcp] with surfaces of the tool and of the table on elastic bodies; mesh, simulate and "
                           "export work without one");
  }
  if (mesh_order > 0) machine_case.machine.order = mesh_order;
  if (!size.empty()) machine_case.size = size;
  mesh::size_factor(machine_case.machine, machine_case.size);
  return machine_case;
}

void require_writable(const std::filesystem::path& out) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error) throw core::InputError("--out " + out.string(), error.message(), "a folder, or a place for a new one");
  if (::access(out.c_str(), W_OK | X_OK) != 0)
    throw core::InputError("--out " + out.string(), "no permission", "a folder that may be written");
}

solver::FullModel build(const solver::Case& machine_case, const std::filesystem::path& out, const std::string& solver) {
  require_writable(out);
  return solver::build_full_model(machine_case.machine,
                                  {mesh::size_factor(machine_case.machine, machine_case.size), out / "cache"},
                                  solver::solver_choice(solver, "--solver"));
}

std::vector<solver::LoadProgram> load_programs(const solver::Case& machine_case,
                                               const std::vector<std::string>& names) {
  std::vector<solver::LoadProgram> programs;
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (std::find(names.begin(), name, *name) != name)
      throw core::InputError("load program '" + *name + "'", "named twice", "each load program once");
    programs.push_back(machine_case.load(*name));
  }
  return programs;
}

namespace {

/// A basis that is spent at the model's order leaves none.
bool has_reference(const ReducedCase& made) { return made.reference.system.order() > made.model.system.order(); }

/// Errors on held-out loads, of the reference too, and how well they are estimated without the full model.
void compare_heldout(ReducedCase& made, const mesh::Machine& machine, const std::vector<solver::LoadProgram>& loads,
                     const std::vector<solver::LoadResult>& full, const std::vector<mesh::Pose>& poses) {
  made.model.errors.clear();
  made.reference.errors.clear();
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const auto add_sensors = [&](const solver::LoadResult& reduced) {
      if (machine.sensors.empty()) return;
      const std::vector<reduction::SensorError> errors = reduction::compare_sensors(full[i], reduced);
      made.sensors.insert(made.sensors.end(), errors.begin(), errors.end());
    };
    if (!has_reference(made)) {
      const solver::LoadResult reduced = reduction::simulate_reduced(made.model, machine, loads[i], poses);
      made.model.errors.push_back(reduction::compare(full[i], reduced));
      add_sensors(reduced);
      continue;
    }
    const reduction::EstimatedRun run =
        reduction::simulate_with_estimate(made.model, made.reference, machine, loads[i], poses);
    reduction::ReductionErrors errors = reduction::compare(full[i], run.result);
    const reduction::Effectivity estimated = reduction::effectivity(full[i], run);
    errors.estimate_max_um = estimated.max_um;
    errors.effectivity = estimated.median;
    made.model.errors.push_back(errors);
    made.effectivities.push_back(estimated);
    add_sensors(run.result);
    made.reference.errors.push_back(reduction::compare(full[i], run.larger));
  }
}

/// The one of all campaigns with the largest TCP error; empty: there is none.
std::string largest_load(const std::vector<const std::vector<solver::LoadResult>*>& campaigns) {
  std::string name;
  double largest = -1.0;
  for (const std::vector<solver::LoadResult>* results : campaigns) {
    for (const solver::LoadResult& result : *results) {
      const double error = reduction::largest_translation(result.tcp);
      if (error > largest) largest = error, name = result.load;
    }
  }
  return name;
}

}  // namespace

ReducedCase make_reduced_model(const solver::FullModel& full, const solver::Case& machine_case,
                               const reduction::ReduceOptions& wanted, bool resume, const std::filesystem::path& out,
                               const std::vector<mesh::Pose>& bounded) {
  ReducedCase made;
  const core::FolderLock lock(out);
  const Stopwatch campaign_time;
  solver::CampaignOptions options;
  options.out = options.checkpoints = out / "campaign";
  options.resume = resume;
  options.keep_snapshots = true;
  const auto training = load_programs(machine_case, machine_case.train);
  const auto heldout = load_programs(machine_case, machine_case.holdout);
  auto held = solver::run_campaign(full, heldout, options);
  const bool moves = !machine_case.machine.axes.empty();
  if (moves) made.off_grid_poses = reduction::random_poses(machine_case.machine, off_grid_poses);
  const reduction::FullRows between = moves ? reduction::full_rows(full, made.off_grid_poses) : reduction::FullRows{};
  std::vector<std::vector<Eigen::Matrix3Xd>> truths;
  for (solver::LoadResult& result : held) {
    if (moves) truths.push_back(reduction::off_grid_truth(machine_case.machine, between, result.snapshots));
    result.snapshots.resize(0, 0);  // before those of all training loads are there too
  }
  const auto trained = solver::run_campaign(full, training, options);
  made.campaign_seconds = campaign_time.seconds();
  made.loads = training.size() + heldout.size();
  made.largest_load = largest_load({&trained, &held});

  reduction::ReduceOptions reduce_options = wanted;
  reduce_options.tolerance_um = machine_case.tolerance_um;
  Eigen::MatrixXd basis;
  made.model = reduction::reduce(full, training, trained, reduce_options, &made.summary, &made.reference,
                                 bounded.empty() ? nullptr : &basis);
  made.model.size = made.reference.size = fmt::format("{} ({} nodes{})", machine_case.size, full.mesh.nodes(),
                                                      machine_case.machine.order == 2 ? ", quadratic" : "");
  const auto poses = mesh::workspace_poses(machine_case.machine);
  made.poses = poses.size();
  compare_heldout(made, machine_case.machine, heldout, held, poses);
  // One load tells: the machine moves and warms up in it.
  if (!heldout.empty())
    made.model.mesh_error = mesh_error_of(full, machine_case, heldout.front(), held.front(), out);
  else if (!training.empty())
    made.model.mesh_error = mesh_error_of(full, machine_case, training.front(), trained.front(), out);
  made.reference.mesh_error = made.model.mesh_error;
  for (std::size_t i = 0; moves && i < heldout.size(); ++i) {
    made.off_grid.push_back(reduction::off_grid_errors(made.model, made.summary.basis, machine_case.machine, heldout[i],
                                                       truths[i], between));
  }
  reduction::write_model(out / "model.rom.h5", made.model);
  if (has_reference(made)) reduction::write_model(out / "reference.rom.h5", made.reference);
  if (moves) reduction::write_off_grid(out / "off_grid.csv", machine_case.machine, made.off_grid_poses, made.off_grid);
  if (!bounded.empty()) {
    tell_what_no_bound_covers(machine_case.machine);
    const Stopwatch bound_time;
    made.bound = reduction::make_bound_model(full, basis, made.model.trained, bounded);
    made.bound_seconds = bound_time.seconds();
    reduction::write_bound(out / "bound.rom.h5", *made.bound);
    made.bounded = evaluate_bound(made.model, *made.bound, machine_case.machine, heldout, held);
  }
  return made;
}

reduction::ReducedModel model_for(const std::filesystem::path& case_path, const std::filesystem::path& model,
                                  const std::filesystem::path& out) {
  if (!model.empty()) {
    reduction::ReducedModel made = reduction::read_model(model);
    if (case_path.empty()) return made;
    const mesh::Machine machine = open_case(case_path, "", 0).machine;
    if (machine.name != made.machine.name) {
      throw core::InputError(model.string(), "a model of the machine '" + made.machine.name + "'",
                             fmt::format("a model of '{}', the machine of {}", machine.name, machine.path.string()));
    }
    if (machine.hash == made.machine.hash)
      made.machine = machine;  // the same, and it knows where its CAD files are
    else
      core::warn(fmt::format(
          "{} was made from another machine.toml than {}; run thermotwin reduce anew to use the present one",
          model.string(), machine.path.string()));
    return made;
  }
  if (case_path.empty()) throw core::UsageError("a CASE or --model model.rom.h5 is needed");
  const solver::Case machine_case = open_case(case_path, "", 0);
  return make_reduced_model(build(machine_case, out), machine_case, {}, true, out).model;
}

std::string error_table(const ReducedCase& made) {
  std::string text = core::format_table(heldout_rows(made));
  if (!made.off_grid.empty()) text += "\n\n" + core::format_table(off_grid_rows(made));
  if (!made.sensors.empty()) text += "\n\n" + core::format_table(sensor_rows(made));
  if (made.model.mesh_error) text += "\n\n" + core::format_table(mesh_error_rows(*made.model.mesh_error));
  return text;
}

}  // namespace thermotwin::tools
