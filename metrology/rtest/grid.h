// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The points of a volumetric grid: deviations of the tool against the workpiece at positions of the linear axes, such
// as spheres that a probe locates again and again (Okenka et al.). A folder has grid.toml (docs/reference/grid.md) and
// points.csv as an R-Test. The errors are estimated as those of an R-Test; component errors of linear axes are among
// them.

#include <filesystem>
#include <string>

#include "core/table.h"
#include "metrology/fit/estimates.h"
#include "metrology/rtest/error_choice.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

/// @throws InputError as RTestRecord::load, and where no linear axis moves
RTestRecord load_grid(const std::filesystem::path& folder);
RTestRecord parse_grid(const std::string& toml, const core::Table& points, const std::string& source);

/// The errors that these points distinguish, taken in this order: location errors of the rotary axes that move and of
/// the table, growth of the scales, rotations of the linear axes, component errors up to a power.
ErrorChoice distinguished_errors(const RTestRecord& record, int order);

/// time_s, cycle, positions of the axes, x_mm, y_mm, z_mm, and the residual rx_um, ry_um, rz_um: measured less fitted.
core::Table residual_table(const RTestRecord& record, const Estimates& estimates);

}  // namespace thermotwin::metrology
