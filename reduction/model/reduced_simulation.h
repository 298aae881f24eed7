// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs load programs on the reduced model and makes the same tables as the full model.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/load_result.h"
#include "solver/operation/load_program.h"

namespace thermotwin::reduction {

/// Inputs and outputs of a run, for bound/error_bound.h.
struct RunRecord {
  struct Step {
    solver::Coefficients c;
    double length_s;
  };
  struct Output {
    double time;            ///< s
    std::size_t steps;      ///< number of steps before it
    Eigen::VectorXd state;  ///< (order) K
  };
  double initial_K = 0;  ///< uniform temperature at the start, above the reference
  bool sdirk = true;     ///< stepped by SDIRK2, as the full model
  std::vector<Step> steps;
  std::vector<Output> outputs;
};

/// Options of one load on the reduced model.
struct ReducedRun {
  double refine = 1.0;           ///< factor on the longest time step
  bool exact = false;            ///< use ExactStepper, else SDIRK2 as the full model
  bool tell = true;              ///< whether to warn if coefficients leave the range of the training
  TrainedRange* seen = nullptr;  ///< receives the range of the run's coefficients
  RunRecord* record = nullptr;   ///< receives inputs and outputs of the run
};

/// Runs a load on the reduced model and returns the tables of the full model.
/// @throws InputError if the machine has other terms or inputs than the model
solver::LoadResult simulate_reduced(const ReducedModel& model, const mesh::Machine& machine,
                                    const solver::LoadProgram& load, const std::vector<mesh::Pose>& poses,
                                    const ReducedRun& how = {});

/// @return the poses of a table tcp.csv, from the rows of its first time
std::vector<mesh::Pose> poses_of(const mesh::Machine& machine, const core::Table& tcp);

/// Compares two results of one load. @throws InputError unless times and poses are equal
ReductionErrors compare(const solver::LoadResult& full, const solver::LoadResult& reduced);

/// How far a sensor of the reduced model is from the full model's in one load.
struct SensorError {
  std::string load, sensor;
  double range_K = 0;           ///< largest less smallest reading of the full model
  double max_K = 0, rms_K = 0;  ///< reduced minus full, at the output times
  double at_s = 0;              ///< time of max_K
};

/// One a sensor, in the order of the table. @throws InputError unless sensors and times are equal
std::vector<SensorError> compare_sensors(const solver::LoadResult& full, const solver::LoadResult& reduced);

}  // namespace thermotwin::reduction
