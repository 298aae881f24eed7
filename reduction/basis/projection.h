// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The full model on a basis: its matrices and output rows, and models of a smaller order.

#include <Eigen/Core>

#include <vector>

#include "reduction/model/output_grid.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/system.h"

namespace thermotwin::reduction {

/// Galerkin projection on columns that are orthonormal in the capacity.
ReducedSystem project_system(const solver::ThermalSystem& thermal, const Eigen::MatrixXd& basis);

/// The model of a smaller order: bases are nested, so its matrices are the leading blocks.
ReducedModel truncated(const ReducedModel& model, Eigen::Index order);

/// Output rows of the full model at the poses that the reduced model stores. Those of the workspace's own positions and
/// angles are kept, since the basis has to see them; those between are many, and are made when they are projected.
class FullOutputs {
public:
  explicit FullOutputs(const solver::FullModel& full);

  const std::vector<solver::OutputRows>& kept() const { return kept_; }

  ReducedOutputs project(const Eigen::MatrixXd& basis) const;

private:
  const solver::FullModel& full_;
  OutputGrid grid_;
  std::vector<solver::OutputRows> kept_;
};

}  // namespace thermotwin::reduction
