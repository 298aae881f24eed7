// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How far a reduced model may be from the full one, without the full one. Its reference is a model of
// larger order whose basis holds the model's own. Both run on the same load; for nested Galerkin bases
// the difference of an output at time t is the model's residual, weighted with that output's adjoint in
// the reference, and summed up to t: the dual-weighted residual in the reference's space. It is exact
// but for what the reference itself misses, so it is an estimate; error_bound.h has a bound.
// Cost: a run of the reference.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/basis/reduce.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {

/// Columns of an estimate after time and pose, without the tool's and the table's parts.
inline constexpr int estimated_values = 6;

struct EstimatedRun {
  solver::LoadResult result;  ///< of the model
  solver::LoadResult larger;  ///< of the reference
  core::Table estimate;       ///< time_s, pose, dx_um .. rc_um_per_m: reference minus model, signed
};

/// @throws InputError if the reference is not of a larger order for the same machine
EstimatedRun simulate_with_estimate(const ReducedModel& model, const ReducedModel& reference,
                                    const mesh::Machine& machine, const solver::LoadProgram& load,
                                    const std::vector<mesh::Pose>& poses, ReducedRun how = {});

/// Estimated over true length of the translations' error, at all times and poses whose true error is at
/// least a tenth of the largest one.
struct Effectivity {
  double median = 0, low = 0, high = 0;  ///< of the ratio; 5 and 95 % of it lie below
  double within_two = 0;                 ///< share between a half and 2
  double max_um = 0;                     ///< largest estimate
};
/// Largest length of dx, dy, dz in a table, um.
double largest_translation(const core::Table& table);
Effectivity effectivity(const solver::LoadResult& full, const EstimatedRun& run);

}  // namespace thermotwin::reduction
