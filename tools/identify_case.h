// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A model identified from a case's campaign, and its errors on the held-out loads.

#include <filesystem>
#include <vector>

#include "reduction/model/reduced_model.h"
#include "reduction/systems/identify.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"

namespace thermotwin::tools {

struct IdentifiedCase {
  reduction::CampaignInputs inputs;
  reduction::Identification model;
  std::vector<reduction::CampaignTables> tables;  ///< of the held-out loads
  std::vector<reduction::Samples> heldout;
  std::vector<std::string> outputs;  ///< names
  double seconds = 0;                ///< to read and to fit

  /// On each held-out load.
  std::vector<reduction::ReductionErrors> errors(Eigen::Index order) const;
};

/// Of the case only names, laws and lists of loads are used. @param order  0: chosen
IdentifiedCase identify_case(const solver::Case& machine_case, const std::filesystem::path& campaign,
                             Eigen::Index order);

}  // namespace thermotwin::tools
