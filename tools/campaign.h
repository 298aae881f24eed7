// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Parts of `campaign` on the full model: the load programs, the settings of the run, and the summary of its results.

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/operation/load_program.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {

/// Load programs asked for: those named, else train and holdout of the case.
std::vector<solver::LoadProgram> campaign_programs(const CampaignOptions& options, const solver::Case& machine_case);

/// @param folder  for tables and checkpoints
solver::CampaignOptions campaign_settings(const CampaignOptions& options, const std::filesystem::path& folder);

struct CampaignSummary {
  std::string text;
  nlohmann::json json;
};

/// Writes campaign/report.html in --out. @param results  of these programs
CampaignSummary present_campaign(const CampaignOptions& options, const std::vector<solver::LoadProgram>& programs,
                                 const solver::FullModel& full, const std::vector<solver::LoadResult>& results,
                                 const Stopwatch& time);

}  // namespace thermotwin::tools
