// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Lines and tables of axes as files for controls.

#include <filesystem>
#include <string>

#include "compensation/online/axis_lines.h"

namespace thermotwin::tools {

/// A table for --lines, a row for each axis: time_s, axis, reference_mm, offset_um, slope_um_per_m, and the largest
/// difference between line and offset: left_travel_um along the axis, left_across_um over the poses of the workspace,
/// those of the rotary axes among them.
/// @param time  s
std::string lines_csv(const std::vector<std::string>& axes, const std::vector<compensation::AxisLine>& lines,
                      double time);

/// Writes axis_<axis>.csv for each axis: position_mm, then the component errors with their names of ISO 230-1.
/// Rows are positions over the workspace; errors are um, and um/m of rotations.
/// @return a sentence with the residual of the sum of the tables over the workspace, um for each direction, with the
///   rotary axes at all their positions and in the middle
std::string write_axis_errors(const std::filesystem::path& folder, const compensation::ErrorTables& tables);

}  // namespace thermotwin::tools
