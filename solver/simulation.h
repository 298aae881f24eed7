// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The main loop: a load program drives a thermal stepper (full or reduced) with chillers in the
// loop. Several programs that share their time grid run as one block.

#include <functional>
#include <vector>

#include "solver/load_program.h"
#include "solver/operating_model.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

struct SimulationOptions {
  double refine = 1.0;        ///< factor of the longest time step
  bool progress = true;
};

/// What is known at an output time of one load.
struct OutputState {
  std::size_t load;                      ///< index into the block
  std::size_t index;                     ///< of the output time
  double time;                           ///< s
  Eigen::Ref<const Eigen::VectorXd> state;
  Eigen::Ref<const Eigen::VectorXd> sensors_K;  ///< readings: with the sensors' own offsets
  const Eigen::VectorXd& row;            ///< channels of the step that ended here
};

/// Runs programs with equal step_ends() as one block.
/// @param on_output  called in order of time for each load at each output time
/// @throws InputError if the time grids differ; Interrupted
void simulate(ThermalStepper& stepper, const OperatingModel& model,
              const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
              const std::function<void(const OutputState&)>& on_output);

/// Groups programs into blocks of equal time grids, in order.
std::vector<std::vector<const LoadProgram*>> blocks_of_equal_grid(
    const std::vector<LoadProgram>& programs, double refine = 1.0);

}  // namespace thermotwin::solver
