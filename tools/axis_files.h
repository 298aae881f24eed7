// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Lines and tables of axes as files for controls.

#include <filesystem>
#include <string>

#include "compensation/online/axis_lines.h"

namespace thermotwin::tools {

/// A row an axis: time_s, axis, reference_mm, offset_um, slope_um_per_m, left_travel_um, left_across_um
std::string lines_csv(const std::vector<std::string>& axes, const std::vector<compensation::AxisLine>& lines,
                      double time);

/// Writes axis_<axis>.csv for each axis: position_mm, then the component errors with their names of ISO 230-1.
/// @return what the tables leave, for the log
std::string write_axis_errors(const std::filesystem::path& folder, const compensation::ErrorTables& tables);

}  // namespace thermotwin::tools
