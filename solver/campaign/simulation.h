// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The main loop: a load program drives a thermal stepper (full or reduced), with chillers in the loop. Programs with
// the same time grid run as one block. A program with error control runs alone, because in a block its steps, and so
// its result, would depend on the other loads.

#include <functional>
#include <string>
#include <vector>

#include "solver/campaign/checkpoint.h"
#include "solver/operation/chiller.h"
#include "solver/operation/layout.h"
#include "solver/operation/load_program.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/heat_balance.h"
#include "solver/thermal/stepper.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

struct SimulationOptions {
  double refine = 1.0;  ///< factor on the longest time step
  bool progress = true;
  Eigen::VectorXd start;  ///< (size) K above the reference at time 0; empty: initial_C of the program
  std::vector<HeatBalance>* balances = nullptr;  ///< one per load; the stepper has to keep its means
  Checkpoint* checkpoint = nullptr;              ///< for resuming the run and for its own checkpoints
  /// Called after each step, before its output, with the coefficients of each load in the step.
  std::function<void(const std::vector<Coefficients>&, double step_s)> on_step;
  void validate() const;  ///< @throws InputError
};

/// The state of one load at an output time.
struct OutputState {
  std::size_t load;   ///< index into the block
  std::size_t index;  ///< of the output time
  double time;        ///< s
  Eigen::Ref<const Eigen::VectorXd> state;
  Eigen::Ref<const Eigen::VectorXd> sensors_K;  ///< (sensors) readings: with the sensors' own offsets
  const Eigen::VectorXd& row;                   ///< channels of the step that ended here
};

/// Statistics of a run.
struct RunSummary {
  long steps = 0, rejected = 0;  ///< accepted steps; steps that were repeated
  long over_tolerance = 0;       ///< steps of the shortest length that were accepted above the tolerance
  long factorisations = 0, iterations = 0, most_factors = 0;
  double shortest_step = 0, longest_step = 0;  ///< s
  struct Switch {
    double time;
    int coolant;
    bool running;
  };
  std::vector<Switch> switches;  ///< of compressors, adaptive runs
  long passes = 0;               ///< solutions of steps whose coefficients depend on the temperature
  long unconverged = 0;          ///< such steps whose last pass changed the state by more than iteration_K
  double resumed_at = 0;         ///< s; > 0: resumed from a checkpoint
  std::string brief() const;
};

/// Runs programs with equal step_ends() as one block.
/// @param on_output  called in order of time for each load at each output time; after a resumed
///                   start only for outputs that the checkpoint does not hold
/// @throws InputError if the time grids differ; Interrupted (a last checkpoint is then written)
RunSummary simulate(ThermalStepper& stepper, const OperatingModel& model,
                    const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
                    const std::function<void(const OutputState&)>& on_output);

/// @return the programs in blocks of equal time grids, in order; a program with error control is alone
std::vector<std::vector<const LoadProgram*>> blocks_of_equal_grid(const std::vector<LoadProgram>& programs,
                                                                  double refine = 1.0);

/// @return the sensors' own offsets, K, followed by zeros for the other observed values of the layout
Eigen::VectorXd sensor_offsets(const mesh::Machine& machine, const Layout& layout);

/// Steps whose coefficients depend on the temperature are repeated until their end changes by less than this, K.
inline constexpr double iteration_K = 1e-7;
inline constexpr int most_passes = 30;

}  // namespace thermotwin::solver
