// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Load programs on the reduced model; tables as the full model's.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/load_result.h"
#include "solver/operation/load_program.h"

namespace thermotwin::reduction {

/// What drove a run and what came of it, for error_bound.h.
struct RunRecord {
  struct Step {
    solver::Coefficients c;
    double length_s;
  };
  struct Output {
    double time;
    std::size_t steps;
    Eigen::VectorXd state;
  };                     ///< steps done before it
  double initial_K = 0;  ///< uniform temperature at the start, above the reference
  bool sdirk = true;     ///< stepped as the full model does
  std::vector<Step> steps;
  std::vector<Output> outputs;
};

/// How a load runs on the reduced model.
struct ReducedRun {
  double refine = 1.0;           ///< factor of the longest time step
  bool exact = false;            ///< by ExactStepper; else as the full model, by SDIRK2
  bool tell = true;              ///< warn where coefficients leave the range of training
  TrainedRange* seen = nullptr;  ///< gets the range of the run's coefficients
  RunRecord* record = nullptr;   ///< gets the run
};

/// Runs a load on the reduced model; tables as the full model's.
/// @throws InputError if the machine has other terms or inputs than the model
solver::LoadResult simulate_reduced(const ReducedModel& model, const mesh::Machine& machine,
                                    const solver::LoadProgram& load, const std::vector<mesh::Pose>& poses,
                                    const ReducedRun& how = {});

/// Poses of a tcp table: those of its first time.
std::vector<mesh::Pose> poses_of(const mesh::Machine& machine, const core::Table& tcp);

/// Difference of two results of one load (same times and poses).
ReductionErrors compare(const solver::LoadResult& full, const solver::LoadResult& reduced);

}  // namespace thermotwin::reduction
