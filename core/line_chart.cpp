// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/line_chart.h"

#include <cmath>

#include "core/plot.h"

namespace thermotwin::core {

std::string LineChart::svg() const {
  const Frame frame{78, 44, 532, 362};
  Axis x{x_title}, y{y_title, log_y};
  for (const Line& line : lines) {
    for (const auto& [at, value] : line.points)
      if (x.shows(at) && y.shows(value)) x.include(at), y.include(value);
  }
  y.include(target);
  x.close();
  y.close(0.04);
  Plot plot(760, 460, title);
  plot.title(frame.left, 26, title);
  Panel panel(plot, frame, x, y);
  panel.y_axis();
  panel.x_axis();
  panel.level(target, target_name);
  double legend = frame.top + 10;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    Eigen::VectorXd at(std::ssize(lines[i].points)), values(at.size());
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      at[k] = lines[i].points[k].first;
      values[k] = lines[i].points[k].second;
    }
    panel.line(at, values, series_ink(i));
    panel.dots(at, values, series_ink(i));
    plot.key(frame.right() + 10, legend, lines[i].name, series_ink(i));
    legend += 20;
  }
  return plot.file();
}

}  // namespace thermotwin::core
