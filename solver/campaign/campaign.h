// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A case and its campaign: all load programs on the full model, the TCP error at all poses of the
// workspace grid, written load by load (tcp.csv, sensors.csv, heat.csv) so that a stopped campaign resumes,
// within a load from its last checkpoint with the same bits.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/model.h"
#include "solver/operation/load_program.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

struct CampaignOptions {
  std::vector<mesh::Pose> poses;    ///< empty: the workspace grid
  double refine = 1.0;              ///< factor of the longest time step; with error control of its tolerance
  std::optional<TimeOptions> time;  ///< for all loads, in place of their own
  bool keep_snapshots = false;
  std::filesystem::path out;  ///< empty: nothing is written; else out/<load>/tcp.csv ..., of a machine with [tcp]
  bool resume = false;        ///< loads with complete files of the same inputs are read, not run;
                              ///< others go on from their checkpoints
  std::filesystem::path checkpoints;  ///< folder; empty: none are written or read
  double checkpoint_s = 60;           ///< wall clock seconds between two
  Eigen::VectorXd start;              ///< (size) K above the reference; empty: initial_C of each load
  /// Called at each output after it is recorded; a resumed run may repeat the last ones.
  std::function<void(const LoadProgram&, const OutputState&)> on_output;
  void validate() const;  ///< @throws InputError
};

std::vector<LoadResult> run_campaign(const FullModel& model, const std::vector<LoadProgram>& loads,
                                     const CampaignOptions& options);

}  // namespace thermotwin::solver
