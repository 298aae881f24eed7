// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A small line plot as inline SVG: two series over time, a band of what is expected, the held-out
// part shaded. Styles come from the page (classes), so that it follows light and dark schemes.

#include <Eigen/Core>

#include <string>
#include <vector>

namespace thermotwin::diagnosis {

struct ResidualPlot {
  std::string title, unit;
  Eigen::VectorXd hours;          ///< (n) rising
  Eigen::VectorXd before, after;  ///< (n) NaN where missing
  Eigen::VectorXd band;           ///< (n) half width about zero, two standard deviations
  double heldout_from = 0;        ///< h
  bool show_after = true;
};

/// Channels over time in colours: residual over what is expected of it, blue below, orange above, pale
/// within two standard deviations. One look says which channels are off, and when.
struct ResidualMap {
  std::vector<std::string> channels;
  Eigen::VectorXd hours;    ///< (n)
  Eigen::MatrixXd ratio;    ///< (n x channels), NaN where nothing was measured
  double heldout_from = 0;  ///< h
};
std::string residual_map_svg(const ResidualMap& map);

std::string residual_svg(const ResidualPlot& plot);

}  // namespace thermotwin::diagnosis
