// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sentences on the points of an R-Test or a grid: circles, drift, places of sphere and tool, calibration. Some are
// figures of the JSON result too; a doubt is a warning.

#include <nlohmann/json_fwd.hpp>

#include <string>

#include "metrology/rtest/analysis.h"
#include "metrology/rtest/record.h"
#include "metrology/rtest/test_points.h"

namespace thermotwin::tools {

/// The geometric circle of the last cycle, and its change from the first one.
std::string arcs_words(const metrology::RTestRecord& record);

/// Cycles without a repeated point, and what their drift does.
std::string drift_words(const metrology::RTestRecord& record, const metrology::RTestAnalysis& analysis);

/// What the channels of location errors know of the points.
std::string points_words(const metrology::TestPoints& points);

/// Where on the table the points are, with a warning where they contradict the positions of the axes.
std::string places_words(const metrology::RTestRecord& record, nlohmann::json& result);

/// The tool point that the points of a grid mean, with a warning where they contradict the positions of the axes.
std::string tool_words(const metrology::RTestRecord& record, nlohmann::json& result);

std::string calibration_words(const metrology::CalibrationCheck& check, nlohmann::json& result);

}  // namespace thermotwin::tools
