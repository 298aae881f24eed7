// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Draws a line chart as a self-contained SVG file, readable in light and dark browsers and in documents.

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace thermotwin::core {

struct LineChart {
  struct Line {
    std::string name;
    std::vector<std::pair<double, double>> points;  ///< x, y; not finite: a gap
  };
  std::string title, x_title, y_title;
  std::vector<Line> lines;  ///< at most eight have a colour of their own
  bool log_y = false;       ///< values <= 0 are gaps
  /// Height of a horizontal line that marks a target; NaN: none.
  double target = std::numeric_limits<double>::quiet_NaN();
  std::string target_name;

  std::string svg() const;
};

}  // namespace thermotwin::core
