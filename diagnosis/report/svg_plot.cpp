// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/svg_plot.h"

#include <algorithm>
#include <cmath>

#include "core/plot.h"

namespace thermotwin::diagnosis {

using core::Anchor;
using core::Axis;
using core::Frame;
using core::Ink;
using Eigen::Index;
using Eigen::VectorXd;

std::string residual_map_svg(const ResidualMap& map) {
  constexpr double row = 15.0;
  constexpr Index most_columns = 120;
  const Index n = map.hours.size(), channels = map.ratio.cols(), columns = std::min(n, most_columns);
  if (n < 2 || channels == 0) return "";
  const Frame frame{110, 0, 850, row * channels};
  Axis time{"time in h", false, map.hours[0], map.hours[n - 1]};
  core::Plot plot(frame.right(), frame.bottom() + 34, "residuals of all channels over time");
  core::Panel panel(plot, frame, time, {"", false, 1.0 * channels, 0.0});
  const double width = (time.high - time.low) / columns;
  for (Index c = 0; c < channels; ++c) {
    plot.text(frame.left - 6, row * (c + 0.75), map.channels[c], Anchor::end);
    for (Index k = 0; k < columns; ++k) {
      double sum = 0.0;
      int count = 0;
      for (Index i = k * n / columns; i < (k + 1) * n / columns; ++i)
        if (std::isfinite(map.ratio(i, c))) sum += map.ratio(i, c), ++count;
      if (count == 0) continue;
      const double value = sum / count, strength = std::clamp((std::abs(value) - 1.0) / 7.0, 0.0, 1.0);
      panel.box(time.low + width * k, time.low + width * (k + 1.0), c + 0.03, c + 0.97,
                value > 0 ? Ink::orange : Ink::blue, 0.06 + 0.94 * strength);
    }
  }
  panel.x_axis();
  panel.mark(map.heldout_from);
  return plot.inset();
}

std::string residual_svg(const ResidualPlot& plot) {
  const Index n = plot.hours.size();
  Axis time{"time in h"}, residual{plot.unit};
  time.include(n > 0 ? plot.hours[0] : 0.0);
  time.include(n > 1 && plot.hours[n - 1] > time.low ? plot.hours[n - 1] : time.low + 1.0);
  residual.include(0.0);
  for (const VectorXd& values : {plot.before, plot.after, plot.band, VectorXd(-plot.band)}) residual.include(values);
  residual.close(0.06);
  core::Plot picture(560, 210, "residual of " + plot.title);
  core::Panel panel(picture, {52, 10, 496, 166}, time, residual);
  panel.shade(plot.heldout_from, time.high);
  panel.band(plot.hours, -plot.band, plot.band);
  panel.y_axis();
  panel.x_axis();
  panel.line(plot.hours, plot.before, Ink::orange);
  if (plot.show_after) panel.line(plot.hours, plot.after, Ink::blue);
  return picture.inset();
}

}  // namespace thermotwin::diagnosis
