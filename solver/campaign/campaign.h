// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs the campaign of a case: all load programs on the full model, with the TCP error at all poses of the workspace
// grid. Results are written load by load (tcp.csv, sensors.csv, heat.csv). An interrupted campaign resumes, within a
// load from its last checkpoint, and ends with the same bits.

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
  double refine = 1.0;              ///< factor on the longest time step; with error control on the tolerance
  std::optional<TimeOptions> time;  ///< for all loads, in place of their own
  bool keep_snapshots = false;
  Eigen::Index field_modes = 0;       ///< > 0: fields of each load, as at most this many modes (load_fields.h)
  std::filesystem::path out;          ///< for `out/<load>/tcp.csv` ..., which need a [tcp]; empty: nothing is written
  bool resume = false;                ///< loads with complete files of the same inputs are read;
                                      ///< the others continue from their checkpoints
  std::filesystem::path checkpoints;  ///< folder; empty: none are written or read
  double checkpoint_s = 60;           ///< wall clock seconds between two
  Eigen::VectorXd start;              ///< (size) K above the reference; empty: initial_C of each load
  /// Called at each output after it is recorded; a resumed run may repeat the last ones.
  std::function<void(const LoadProgram&, const OutputState&)> on_output;
  void validate() const;  ///< @throws InputError
};

/// @return one result per load, in the order of loads
/// @throws InputError for a machine without [tcp] if tables are to be written; SolverError; Interrupted
std::vector<LoadResult> run_campaign(const FullModel& model, const std::vector<LoadProgram>& loads,
                                     const CampaignOptions& options);

}  // namespace thermotwin::solver
