// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The result of one load on the full or the reduced model.

#include <optional>
#include <string>

#include "core/table.h"
#include "solver/campaign/load_fields.h"
#include "solver/campaign/simulation.h"
#include "solver/thermal/heat_balance.h"

namespace thermotwin::solver {

/// Tables and summaries of one load.
struct LoadResult {
  std::string load;
  core::Table tcp;                  ///< one row per time and pose; no columns: a machine without [tcp]
  core::Table sensors;              ///< time_s, `<sensor>_C`
  core::Table inputs;               ///< time_s and the channel rows (means since the last output)
  Eigen::MatrixXd snapshots;        ///< (size x outputs) temperatures, if asked for
  LoadFields fields;                ///< temperatures at some outputs as modes, if asked for
  std::optional<HeatBalance> heat;  ///< of the run; empty if the result was read from files
  RunSummary run;                   ///< of all loads that ran side by side with this one; empty if read from files
  core::Table heat_flows;           ///< heat.csv, see HeatBalance::columns; empty: of a reduced model
};

}  // namespace thermotwin::solver
