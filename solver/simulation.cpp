// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/simulation.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/progress.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// What drives one load: its program, its chillers, what they and the machine are told.
struct Drive {
  const LoadProgram* program;
  std::optional<Chiller> chiller;
  VectorXd row;
};

int air_index(const mesh::Machine& machine) {
  for (std::size_t i = 0; i < machine.ambients.size(); ++i)
    if (machine.ambients[i].id == "air") return static_cast<int>(i);
  return -1;
}

std::string label(const std::vector<const LoadProgram*>& programs) {
  return programs.size() == 1 ? "thermal run '" + programs.front()->name() + "'"
                              : fmt::format("thermal run of {} loads", programs.size());
}

}  // namespace

void simulate(ThermalStepper& stepper, const OperatingModel& model, const std::vector<const LoadProgram*>& programs,
              const SimulationOptions& options, const std::function<void(const OutputState&)>& on_output) {
  if (programs.empty()) return;
  const mesh::Machine& machine = model.machine();
  const std::vector<double> ends = programs.front()->step_ends(options.refine);
  const std::vector<double> outputs = programs.front()->output_times();
  for (const LoadProgram* program : programs)
    if (program->step_ends(options.refine) != ends || program->output_times() != outputs)
      throw core::InputError("load '" + program->name() + "'", "another time grid than '" + programs.front()->name() + "'",
                             "programs of equal phases, time_step_s and output_s in one block");

  const int air = air_index(machine);
  const auto air_K = [&](const VectorXd& row) { return air >= 0 ? model.ambient_K(air, row) : 0.0; };
  VectorXd offsets(static_cast<Index>(machine.sensors.size()));
  for (Index s = 0; s < offsets.size(); ++s) offsets[s] = machine.sensors[static_cast<std::size_t>(s)].offset;

  const auto loads = static_cast<Index>(programs.size());
  Eigen::MatrixXd state(stepper.size(), loads);
  for (Index l = 0; l < loads; ++l)
    state.col(l) = stepper.uniform(programs[static_cast<std::size_t>(l)]->initial_C() - machine.reference_C);
  Eigen::MatrixXd readings = stepper.sensors(state).colwise() + offsets;

  std::vector<Drive> drives;
  for (Index l = 0; l < loads; ++l) {
    Drive drive{programs[static_cast<std::size_t>(l)], std::nullopt, {}};
    drive.row = drive.program->row(0.0, ends.front());
    drive.chiller.emplace(machine, model.channels(), chiller_set_points(machine, readings.col(l), air_K(drive.row)));
    drives.push_back(std::move(drive));
  }

  std::size_t next_output = 0;
  const auto report = [&](double time) {
    for (std::size_t l = 0; l < drives.size(); ++l) {
      const auto column = static_cast<Index>(l);
      on_output({l, next_output, time, state.col(column), readings.col(column), drives[l].row});
    }
    ++next_output;
  };
  report(0.0);

  std::optional<core::Progress> progress;
  if (options.progress) progress.emplace(label(programs), ends.size());
  std::vector<Coefficients> coefficients(drives.size());
  double time = 0.0;
  for (double end : ends) {
    const double step = end - time;
    for (std::size_t l = 0; l < drives.size(); ++l) {
      Drive& drive = drives[l];
      drive.row = drive.program->row(time, end);
      const VectorXd& inlet = drive.chiller->advance(drive.row, readings.col(static_cast<Index>(l)), air_K(drive.row), step);
      model.coefficients(drive.row, inlet, coefficients[l]);
    }
    stepper.advance(state, coefficients, step);
    readings = stepper.sensors(state).colwise() + offsets;
    time = end;
    if (next_output < outputs.size() && end >= outputs[next_output] - 1e-9 * ends.back()) report(end);
    if (progress)
      progress->advance();
    else
      core::check_interrupt();
  }
}

std::vector<std::vector<const LoadProgram*>> blocks_of_equal_grid(const std::vector<LoadProgram>& programs, double refine) {
  std::vector<std::vector<const LoadProgram*>> blocks;
  for (const LoadProgram& program : programs) {
    const auto ends = program.step_ends(refine);
    const auto outputs = program.output_times();
    bool placed = false;
    for (auto& block : blocks)
      if (!placed && block.front()->step_ends(refine) == ends && block.front()->output_times() == outputs) {
        block.push_back(&program);
        placed = true;
      }
    if (!placed) blocks.push_back({&program});
  }
  return blocks;
}

}  // namespace thermotwin::solver
