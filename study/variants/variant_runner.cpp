// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/variant_runner.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/adaptive_simulation.h"
#include "solver/campaign/checkpoint.h"
#include "solver/campaign/recorder.h"
#include "solver/campaign/simulation_block.h"
#include "solver/linear/available_memory.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/integrator.h"
#include "study/units/resources.h"
#include "study/units/unit_work.h"
#include "study/variants/variant_recorder.h"

namespace thermotwin::study {

namespace fs = std::filesystem;

struct VariantRunner::Full {
  std::string matrices;
  solver::FullModel model;
  std::vector<mesh::Pose> poses;
  Eigen::MatrixXd rows;  // see error_rows
};

namespace {

/// Vectors of the size of the unknowns that a block keeps for each variant, without recycled ones.
constexpr double vectors_per_variant = 16.0;

double block_bytes(const VariantUnit& unit, Eigen::Index size, int recycled) {
  const double values = size;
  return values * unit.variants.size() * (vectors_per_variant + 2.0 * recycled) * sizeof(double);
}

void require_memory_of(const StudyPlan& plan, const VariantUnit& unit, Eigen::Index size, int recycled) {
  const double need = block_bytes(unit, size, recycled), available = 0.9 * solver::available_memory();
  const auto fitting = static_cast<long>(available / need * unit.variants.size());
  require_memory({need, fmt::format("{} variants of {} unknowns", unit.variants.size(), size),
                  fmt::format("block = {} or less", std::max(1L, fitting))},
                 fmt::format("{} block", plan.path.string()), available);
}

}  // namespace

VariantRunner::VariantRunner(const StudyPlan& plan, const Design& design, RunnerOptions options)
    : plan_(plan),
      design_(design),
      options_(std::move(options)) {}

VariantRunner::~VariantRunner() = default;

Eigen::Index VariantRunner::nodes() const { return full_ ? full_->model.mesh.nodes() : 0; }

UnitFiles VariantRunner::run(const VariantUnit& unit, const fs::path& folder) {
  said_.clear();
  UnitFiles files = write_tables(
      folder, unit,
      options_.reduced != nullptr ? on_reduced_model(unit) : on_full_model(unit, folder / checkpoint_file));
  if (!said_.empty()) core::log_line(said_);
  return files;
}

std::vector<VariantTables> VariantRunner::on_reduced_model(const VariantUnit& unit) {
  const solver::LoadProgram program = plan_.machine_case.load(unit.load);
  std::vector<VariantTables> tables(unit.variants.size());
  core::Progress progress("variants of '" + unit.load + "'", unit.variants.size());
  core::parallel_for(0, unit.variants.size(), [&](std::size_t i) {
    const mesh::Machine machine = machine_of(plan_, design_.variants[unit.variants[i]].values);
    const reduction::ReducedModel model = diagnosis::model_of_changed(*options_.reduced, machine);
    reduction::ReducedRun how;
    how.tell = false;
    solver::LoadResult result =
        reduction::simulate_reduced(model, machine, program, mesh::workspace_poses(machine), how);
    const Eigen::Index kept = 1 + std::ssize(machine.axes) + 6;
    tables[i].tcp.columns.assign(result.tcp.columns.begin(), result.tcp.columns.begin() + kept);
    tables[i].tcp.values = result.tcp.values.leftCols(kept);
    tables[i].sensors = std::move(result.sensors);
    progress.advance();
  });
  return tables;
}

std::vector<VariantTables> VariantRunner::on_full_model(const VariantUnit& unit, const fs::path& checkpoint_path) {
  const mesh::Machine& nominal = plan_.machine_case.machine;
  if (!full_ || full_->matrices != unit.matrices) {
    full_.reset();  // before the next one: two do not fit into a small memory
    const mesh::Machine machine = machine_of(plan_, design_.variants[unit.variants.front()].values);
    solver::FullModel model =
        solver::build_full_model(machine, {mesh::size_factor(nominal, unit.size), options_.cache}, options_.solver);
    std::vector<mesh::Pose> poses = mesh::workspace_poses(nominal);
    Eigen::MatrixXd rows = error_rows(machine, poses, solver::stacked_rows(model, poses));
    full_ = std::make_unique<Full>(Full{unit.matrices, std::move(model), std::move(poses), std::move(rows)});
  }
  const solver::ThermalSystem& thermal = full_->model.thermal;
  require_memory_of(plan_, unit, thermal.size, options_.recycled);
  const solver::LoadProgram program = plan_.machine_case.load(unit.load);
  std::vector<solver::OperatingModel> operating;
  operating.reserve(unit.variants.size());
  for (const std::size_t variant : unit.variants)
    operating.emplace_back(machine_of(plan_, design_.variants[variant].values), thermal.layout);
  VariantRecorder recorder(full_->model.mesh.machine, full_->poses, full_->rows, operating.size(),
                           program.output_times().size());
  const solver::TimeScheme scheme = program.time().scheme;
  if (scheme == solver::TimeScheme::adaptive) {
    // Steps follow the error of each variant: one after another, all outputs of one before those of the next.
    std::vector<VariantTables> tables;
    for (const solver::OperatingModel& model : operating) {
      VariantRecorder alone(full_->model.mesh.machine, full_->poses, full_->rows, 1, program.output_times().size());
      solver::AdaptiveIntegrator integrator(thermal);
      simulate_adaptive(integrator, model, program, {}, [&](const solver::OutputState& out) { alone.add(out); });
      tables.push_back(std::move(alone.take().front()));
    }
    return tables;
  }
  solver::Checkpoint checkpoint(checkpoint_path, unit.id, {unit.id}, options_.checkpoint_s, true);
  checkpoint.save_rest = [&](core::BinaryWriter& out) { recorder.save(out); };
  checkpoint.load_rest = [&](core::BinaryReader& in) { recorder.load(in); };
  std::vector<const solver::OperatingModel*> models;
  for (const solver::OperatingModel& model : operating) models.push_back(&model);
  solver::SimulationOptions simulation;
  simulation.checkpoint = &checkpoint;
  solver::IntegratorOptions integrating;
  integrating.backward_euler = scheme == solver::TimeScheme::backward_euler;
  integrating.tolerance = options_.tolerance;
  integrating.recycled = options_.recycled;
  integrating.factor_memory = 0.0;  // one factor for the block: its solves run side by side
  solver::ThermalIntegrator integrator(thermal, integrating);
  const solver::RunSummary summary =
      solver::simulate_block(integrator, models, std::vector<const solver::LoadProgram*>(models.size(), &program),
                             simulation, [&](const solver::OutputState& out) { recorder.add(out); });
  said_ = fmt::format("unit {}: {} variants of '{}', {} steps, {} iterations, {} factorisations", unit.id,
                      unit.variants.size(), unit.load, summary.steps, integrator.statistics().iterations,
                      integrator.statistics().factorisations);
  return recorder.take();
}

double disk_need(const StudyPlan& plan, const VariantUnit& unit) {
  const mesh::Machine& machine = plan.machine_case.machine;
  const double poses = mesh::workspace_poses(machine).size();
  const double per_row = 7 + machine.axes.size();
  const double outputs = plan.machine_case.load(unit.load).output_times().size();
  return unit.variants.size() * table_bytes(outputs * (poses * per_row + machine.sensors.size() + 1.0));
}

MemoryWanted memory_need(const StudyPlan& plan, const std::vector<VariantUnit>& units,
                         const std::vector<std::size_t>& pending, const RunnerOptions& options) {
  const mesh::Machine& machine = plan.machine_case.machine;
  std::map<std::string, Eigen::Index> nodes;
  MemoryWanted most;
  for (const std::size_t u : pending) {
    const VariantUnit& unit = units[u];
    if (!nodes.contains(unit.size))
      nodes[unit.size] = nodes_of_mesh(machine, mesh::size_factor(machine, unit.size), options.cache);
    const double bytes = model_bytes(nodes[unit.size]) + block_bytes(unit, nodes[unit.size], options.recycled);
    if (bytes <= most.bytes) continue;
    most.bytes = bytes;
    most.words = fmt::format("{} variants of {} nodes", unit.variants.size(), nodes[unit.size]);
    most.remedy = "more memory, a smaller block in the plan, or a coarser size";
  }
  return most;
}

}  // namespace thermotwin::study
