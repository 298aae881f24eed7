// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pictures of a study of variants, to stand in a page with core::plot_style().

#include <string>
#include <vector>

#include "study/statistics/sensitivity.h"
#include "study/variants/variant_results.h"

namespace thermotwin::study {

/// Median and the band from the 5th to the 95th percentile over time at one pose: length of the translation, X, Y, Z.
/// @param pose  row of the pose at each time  @param poses  of the workspace
std::string quantiles_svg(const LoadStudy& load, Eigen::Index pose, Eigen::Index poses);

/// First-order (left of each pair) and total share of each parameter with their 95 % intervals, the largest first.
/// @param most  parameters at most
std::string shares_svg(const std::vector<std::string>& names, const Sensitivity& sensitivity, std::size_t most);

}  // namespace thermotwin::study
