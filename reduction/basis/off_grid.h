// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Error of a reduced model at poses between its stored ones, where its output rows are interpolated. The reference is
// the full model: its own output rows at these poses times its temperatures under held-out loads.

#include <Eigen/Core>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/basis/reduce.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// Random poses. An axis of the workspace is uniform between its outermost positions, an endless axis over one turn,
/// any other axis over its travel. The same seed gives the same poses on every computer.
std::vector<mesh::Pose> random_poses(const mesh::Machine& machine, int count, std::uint64_t seed = 20);

/// Output rows of the full model at given poses.
struct FullRows {
  std::vector<mesh::Pose> poses;
  std::vector<solver::OutputRows> rows;
};
FullRows full_rows(const solver::FullModel& full, std::vector<mesh::Pose> poses);

/// Translations of the TCP error at these poses, (3 x output times) in um each.
/// @param snapshots  (size x output times) temperatures of one load, K above the reference
std::vector<Eigen::Matrix3Xd> off_grid_truth(const mesh::Machine& machine, const FullRows& full,
                                             const Eigen::MatrixXd& snapshots);

struct OffGridErrors {
  std::string load;
  /// (poses) um, lengths of translations over all times. peak: largest of the full model. max and rms: largest and RMS
  /// of reduced minus full. own_rows: largest of reduced minus full, with the full model's rows at these poses in place
  /// of interpolated ones.
  Eigen::VectorXd peak, max, rms, own_rows;
  double peak_um() const { return peak.maxCoeff(); }
  double max_um() const { return max.maxCoeff(); }
  double own_rows_um() const { return own_rows.maxCoeff(); }
};

/// @param basis  (size x order) of the model
/// @param truth  of the load
OffGridErrors off_grid_errors(const ReducedModel& model, const Eigen::MatrixXd& basis, const mesh::Machine& machine,
                              const solver::LoadProgram& load, const std::vector<Eigen::Matrix3Xd>& truth,
                              const FullRows& full);

/// One row for each load and pose.
void write_off_grid(const std::filesystem::path& path, const mesh::Machine& machine,
                    const std::vector<mesh::Pose>& poses, const std::vector<OffGridErrors>& errors);

}  // namespace thermotwin::reduction
