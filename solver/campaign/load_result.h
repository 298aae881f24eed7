// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What one load leaves on the full or the reduced model.

#include <optional>
#include <string>

#include "core/table.h"
#include "solver/campaign/simulation.h"
#include "solver/thermal/heat_balance.h"

namespace thermotwin::solver {

/// Result of one load on the full model.
struct LoadResult {
  std::string load;
  core::Table tcp;                  ///< one row per time and pose; no columns: a machine without [tcp]
  core::Table sensors;              ///< time_s, <sensor>_C
  core::Table inputs;               ///< time_s and the channel rows (means since the last output)
  Eigen::MatrixXd snapshots;        ///< (size x outputs) temperatures, if asked for
  std::optional<HeatBalance> heat;  ///< of the run; empty where files were read
  RunSummary run;                   ///< of the block that the load ran in; empty where files were read
  core::Table heat_flows;           ///< heat.csv, see HeatBalance::columns; empty: of a reduced model
};

}  // namespace thermotwin::solver
