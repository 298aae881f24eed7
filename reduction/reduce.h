// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Basis and projection. Candidates: rational block Krylov vectors (K(p) + s E)^-1 [inputs] and
// their adjoints for the TCP outputs and sensors, at shifts over the time constants and at
// parameter points (films still and fast, fluids on and off, axes at middle and ends), each scaled
// by its typical amplitude in K; and snapshots of the campaign. They are compressed by a proper
// orthogonal decomposition in the capacity's inner product; the order is the smallest one that
// keeps the stated tolerance on the training loads.

#include <string>
#include <vector>

#include "reduction/reduced_model.h"
#include "solver/campaign.h"

namespace thermotwin::reduction {

struct ReduceOptions {
  double tolerance_um = 0.05;      ///< TCP error of the training loads, all poses, translations
  Eigen::Index max_order = 240;
  Eigen::Index order = 0;          ///< > 0: this order instead of the tolerance
};

struct ReduceSummary {
  Eigen::Index candidates = 0, deflated = 0, order = 0;
  double basis_seconds = 0, projection_seconds = 0;
  std::vector<std::pair<Eigen::Index, double>> order_error_um;  ///< tried orders, training error
  std::string brief() const;
};

/// @param training  results of the training loads with snapshots (may be empty: Krylov only)
ReducedModel reduce(const solver::FullModel& full, const std::vector<solver::LoadProgram>& loads,
                    const std::vector<solver::LoadResult>& training, const ReduceOptions& options,
                    ReduceSummary* summary = nullptr);

/// Runs a load on the reduced model; tables as the full model's.
solver::LoadResult simulate_reduced(const ReducedModel& model, const mesh::Machine& machine,
                                    const solver::LoadProgram& load,
                                    const std::vector<mesh::Pose>& poses, double refine = 1.0);

/// Poses of a tcp table: those of its first time.
std::vector<mesh::Pose> poses_of(const mesh::Machine& machine, const core::Table& tcp);

/// Difference of two results of one load (same times and poses).
ReductionErrors compare(const solver::LoadResult& full, const solver::LoadResult& reduced);

}  // namespace thermotwin::reduction
