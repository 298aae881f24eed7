// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/error.h"
#include "core/range.h"
#include "solver/campaign/simulation_block.h"
#include "solver/operation/layout.h"
#include "solver/thermal/stepper.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd sensor_offsets(const mesh::Machine& machine, const Layout& layout) {
  const auto sensors = std::ssize(machine.sensors);
  VectorXd offsets = VectorXd::Zero(sensors + std::ssize(layout.observed));
  for (Index s = 0; s < sensors; ++s) offsets[s] = machine.sensors[s].offset;
  return offsets;
}

void SimulationOptions::validate() const {
  core::require_within("simulation options: refine", refine, core::positive);
  if (!start.allFinite())
    throw core::InputError("simulation options: start", "a temperature that is not a number", "finite values");
}

std::string RunSummary::brief() const {
  std::string text = fmt::format("{} steps of {:.4g} to {:.4g} s, {} factorisations, {} iterations", steps,
                                 shortest_step, longest_step, factorisations, iterations);
  if (rejected > 0) text += fmt::format(", {} steps repeated", rejected);
  if (over_tolerance > 0) text += fmt::format(", {} shortest steps above the tolerance", over_tolerance);
  if (passes > 0) text += fmt::format(", {:.2f} iterations per step", 1.0 * passes / std::max(1L, steps));
  if (unconverged > 0)
    text += fmt::format(", {} steps whose coefficients did not settle to {:.0e} K", unconverged, iteration_K);
  if (!switches.empty()) text += fmt::format(", {} compressor switches", switches.size());
  if (resumed_at > 0) text += fmt::format("; resumed at {:.0f} s", resumed_at);
  return text;
}

RunSummary simulate(ThermalStepper& stepper, const OperatingModel& model,
                    const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
                    const std::function<void(const OutputState&)>& on_output) {
  return simulate_block(stepper, std::vector<const OperatingModel*>(programs.size(), &model), programs, options,
                        on_output);
}

std::vector<std::vector<const LoadProgram*>> blocks_of_equal_grid(const std::vector<LoadProgram>& programs,
                                                                  double refine) {
  std::vector<std::vector<const LoadProgram*>> blocks;
  for (const LoadProgram& program : programs) {
    const auto ends = program.step_ends(refine);
    const auto outputs = program.output_times();
    const TimeScheme scheme = program.time().scheme;
    bool placed = false;
    for (auto& block : blocks) {
      if (!placed && scheme != TimeScheme::adaptive && block.front()->time().scheme == scheme &&
          block.front()->step_ends(refine) == ends && block.front()->output_times() == outputs) {
        block.push_back(&program);
        placed = true;
      }
    }
    if (!placed) blocks.push_back({&program});
  }
  return blocks;
}

}  // namespace thermotwin::solver
