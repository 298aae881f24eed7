// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pictures of an online validation, to stand in a page with core::plot_style().

#include <string>
#include <vector>

#include "compensation/evaluation/validation.h"
#include "core/plot.h"

namespace thermotwin::compensation {

/// One value a machine; columns of one group stand together.
struct DotColumn {
  std::string group, name;
  std::vector<double> values;
  core::Ink ink = core::Ink::blue;
};
/// Dots, a bar from the 10th to the 90th percentile, a stroke at the median. Values that are not finite are left out.
std::string dots_svg(const std::string& name, const std::string& y_title, const std::vector<DotColumn>& columns);

/// RMS removed on each machine, for each load without sensors, with known surroundings, and with sensors.
std::string removal_svg(const Validation& validation);

/// X, Y and Z of one check point over time: before and after, and beside it what is left, enlarged, with two stated
/// standard deviations about zero.
std::string trace_svg(const ValidationTrace& trace);
/// What the colours of trace_svg() mean, as markup of a page.
std::string trace_legend();

}  // namespace thermotwin::compensation
