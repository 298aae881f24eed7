// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Errors of the channels of a diagnosis: noise, what wanders in sensor and model, and shares of the mesh and of
// material data in what has moved.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/record/observations.h"
#include "diagnosis/response/mesh_allowance.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/weighted_points.h"

namespace thermotwin::diagnosis {

struct Floor {
  double noise, slow, fast;
};
/// Below this neither a sensor nor a mesh is exact, and a reduced model shows quick ripples where
/// the full one stands still: few vectors make a body's inside.
Floor floor_of(const ObservedChannel& channel);

struct MaterialSpread {
  double expansion = 0, heat = 0;  ///< largest stated relative standard deviations
};
MaterialSpread material_spread(const mesh::Machine& machine);

/// Fills amplitude and covariance of all channels. @param errors  of the tests
void set_covariances(Problem& problem, const MeshAllowance& allowance, const MaterialSpread& spread,
                     const std::vector<TestErrors>& errors);

/// Of measured minus predicted without a cause, in the channels' own units.
Eigen::VectorXd expected_std(const Problem& problem);

}  // namespace thermotwin::diagnosis
