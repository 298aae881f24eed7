// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a reduced model is off by between its stored poses, where its output rows are interpolated:
// against the full model's own rows there, times the full model's temperatures of held-out loads.

#include <Eigen/Core>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/basis/reduce.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// Poses at random: axes of the workspace evenly between their outermost positions, others over their travel
/// (an endless one: a turn). The same seed gives the same poses on every machine.
std::vector<mesh::Pose> random_poses(const mesh::Machine& machine, int count, std::uint64_t seed = 20);

/// The full model at some poses.
struct FullRows {
  std::vector<mesh::Pose> poses;
  std::vector<solver::OutputRows> rows;
};
FullRows full_rows(const solver::FullModel& full, std::vector<mesh::Pose> poses);

/// Translations of a load there, (3 x output times) in um for each pose. @param snapshots  (size x output times)
std::vector<Eigen::Matrix3Xd> off_grid_truth(const mesh::Machine& machine, const FullRows& full,
                                             const Eigen::MatrixXd& snapshots);

struct OffGridErrors {
  std::string load;
  /// (poses) um, translations: largest of the full model, reduced minus full, RMS of that, and reduced minus
  /// full where the reduced model has these poses' own rows, not interpolated ones.
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
