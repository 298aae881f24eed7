// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The analysis of a record as JSON: errors of each cycle with their covariance, and circles fitted to a continuous
// R-Test.

#include <nlohmann/json_fwd.hpp>

#include "metrology/rtest/analysis.h"
#include "metrology/rtest/record.h"

namespace thermotwin::tools {

nlohmann::json json_of(const metrology::Estimates& analysis);
/// Circles by three methods, and the names of what they tell; empty for a record that is not continuous.
nlohmann::json arcs_json(const metrology::RTestRecord& record);

}  // namespace thermotwin::tools
