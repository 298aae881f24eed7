// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pictures of what `measure analyse` finds, as SVG.

#include <string>

#include "core/table.h"
#include "metrology/fit/estimates.h"

namespace thermotwin::tools {

/// Observable errors over time with the band of U (k = 2), a panel for each unit, at most eight errors each: those of
/// the largest range. Empty: fewer than two cycles.
std::string over_time(const metrology::Estimates& estimates, const std::string& name);

/// Residuals of the last cycle in the three planes of the machine: a stroke from each point, in the direction of the
/// residual. @param residuals  as metrology::residual_table
std::string residual_picture(const core::Table& residuals);

/// The fitted surface of the last cycle, less its mean and without its plane, with the measured points.
/// @param map, points  as metrology::surface_map and surface_points
std::string surface_picture(const core::Table& map, const core::Table& points);

}  // namespace thermotwin::tools
