// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Records one load while it runs: tables that grow output by output, snapshots of the temperature at all outputs, and
// fields at some. Temperatures go to files beside the checkpoint, if there is one.

#include <optional>
#include <vector>

#include "core/binary.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/campaign/state_spool.h"

namespace thermotwin::solver {

inline constexpr Eigen::Index rows_per_pose = 19;  ///< tool 6, table axis 6, table own 7

/// Output rows of all poses in one matrix: a time costs one product for the whole workspace.
/// @return (rows_per_pose * poses x size); no rows for a machine without [tcp]
Eigen::MatrixXd stacked_rows(const FullModel& model, const std::vector<mesh::Pose>& poses);

class Recorder {
public:
  /// All arguments but options must outlive the recorder.
  /// @param spool  folder for temperatures during the run; empty: memory
  Recorder(const FullModel& model, const LoadProgram& load, const std::vector<mesh::Pose>& poses,
           const Channels& channels, const HeatBalance& balance, const CampaignOptions& options,
           const std::filesystem::path& spool);
  /// @param rows     (rows_per_pose * poses x size)
  /// @param balance  of the load, up to this output
  void add(const OutputState& output, const Eigen::MatrixXd& rows, const HeatBalance& balance);
  LoadResult take();
  /// Removes the spool files, after the results are written and the checkpoint is removed.
  void discard_spool() const;

  void save(core::BinaryWriter& out);
  void load(core::BinaryReader& in);

private:
  Eigen::Index kept_filled() const;  ///< how many of kept_ are below filled_
  const mesh::Machine& machine_;
  const std::vector<mesh::Pose>& poses_;
  LoadResult result_;
  Eigen::Index filled_ = 0;
  Eigen::VectorXd heat_;            // J up to the last output, see HeatBalance::amounts
  double heat_until_ = 0;           // s
  std::vector<Eigen::Index> kept_;  // outputs whose fields are kept, in order
  Eigen::Index most_modes_;
  std::optional<StateSpool> snapshots_, fields_;
};

/// @return the means of the channels between outputs; the first row is that of the first step
core::Table input_table(const LoadProgram& load, const Channels& channels, double refine);

}  // namespace thermotwin::solver
