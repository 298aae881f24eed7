// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The page of `campaign`: the machine in 3-D under each load program, and the verb's table.

#include <string>
#include <vector>

#include "solver/campaign/full_model.h"
#include "solver/export/machine_scene.h"
#include "solver/operation/load_program.h"
#include "tools/options.h"

namespace thermotwin::tools {

struct CampaignResults {
  const CampaignOptions& options;
  std::string model;  ///< what computed the loads, in words
  const std::vector<solver::LoadProgram>& loads;
  const solver::MachineScene& scene;
  const std::vector<std::vector<std::string>>& table;  ///< as printed; the first row is the header
  const solver::FullModel* full = nullptr;             ///< nullptr: the reduced model
};

std::string campaign_page(const CampaignResults& results);

}  // namespace thermotwin::tools
