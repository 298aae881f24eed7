// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/reduced_scene.h"

#include <fmt/format.h>

#include <exception>
#include <string_view>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/load_fields.h"
#include "solver/export/scene_file.h"
#include "solver/linear/field_modes.h"

namespace thermotwin::tools {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

struct ReducedLoad {
  core::Table tcp;
  MatrixXd states;  ///< (order x thinned times)
};

std::vector<ReducedLoad> run_loads(const reduction::ReducedModel& model,
                                   const std::vector<solver::LoadProgram>& loads) {
  std::vector<ReducedLoad> runs(loads.size());
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(model.machine);
  core::parallel_for(0, loads.size(), [&](std::size_t i) {
    reduction::RunRecord record;
    reduction::ReducedRun how;
    how.tell = false;
    how.record = &record;
    runs[i].tcp = reduction::simulate_reduced(model, model.machine, loads[i], poses, how).tcp;
    const std::vector<Index> kept = solver::thinned(std::ssize(record.outputs), solver::LoadFields::most_times);
    runs[i].states.resize(model.system.order(), std::ssize(kept));
    for (std::size_t k = 0; k < kept.size(); ++k) runs[i].states.col(k) = record.outputs[kept[k]].state;
  });
  return runs;
}

void add_loads(solver::MachineScene& scene, const std::vector<solver::LoadProgram>& loads,
               const std::vector<ReducedLoad>& runs) {
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const MatrixXd coefficients =
        scene.turn.size() > 0 ? MatrixXd(scene.turn.transpose() * runs[i].states) : MatrixXd();
    scene.loads.push_back(solver::scene_load(loads[i].name(), runs[i].tcp, std::ssize(scene.poses), coefficients));
  }
}

}  // namespace

std::string scene_stamp(const reduction::ReducedModel& model) {
  const MatrixXd& matrix = model.system.conduction;
  return core::content_hash({reinterpret_cast<const char*>(matrix.data()), matrix.size() * sizeof(double)});
}

solver::MachineScene reduced_scene(const solver::FullModel& full, const reduction::ReducedModel& model,
                                   const MatrixXd& basis, const std::vector<solver::LoadProgram>& loads) {
  const std::vector<ReducedLoad> runs = run_loads(model, loads);
  solver::FieldModes modes(solver::scene_modes);
  for (const ReducedLoad& run : runs)
    for (Index k = 0; k < run.states.cols(); ++k) modes.add(run.states.col(k));
  const MatrixXd turn = modes.take().modes;
  solver::MachineScene scene = solver::make_scene(full, basis * turn);
  scene.turn = turn;
  add_loads(scene, loads, runs);
  return scene;
}

void write_reduced_scene(const std::filesystem::path& file, const solver::FullModel& full, const ReducedCase& made,
                         const solver::Case& machine_case) {
  try {
    const solver::MachineScene scene =
        reduced_scene(full, made.model, made.summary.basis, load_programs(machine_case, machine_case.train));
    solver::write_scene(file, scene, scene_stamp(made.model));
  } catch (const core::Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    core::warn(fmt::format("{} is left out: {}", file.string(), error.what()));
  }
}

solver::MachineScene reduced_scene(const std::filesystem::path& scene_file, const reduction::ReducedModel& model,
                                   const std::vector<solver::LoadProgram>& loads) {
  solver::MachineScene scene;
  if (auto stored = solver::read_scene(scene_file, model.machine, scene_stamp(model))) {
    scene = std::move(*stored);
  } else {
    scene.machine = model.machine;
    scene.poses = mesh::workspace_poses(scene.machine);
    scene.keys = solver::key_poses(scene.machine, scene.poses);
  }
  add_loads(scene, loads, run_loads(model, loads));
  return scene;
}

}  // namespace thermotwin::tools
