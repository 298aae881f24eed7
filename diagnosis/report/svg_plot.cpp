// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/svg.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double width = 560, height = 210, left = 52, right = 12, top = 10, bottom = 34;
constexpr Index most_points = 400;

struct Scale {
  double low, high, from, to;
  double operator()(double value) const { return from + (value - low) / (high - low) * (to - from); }
};

/// Lines break at gaps of the data.
std::string path(const VectorXd& hours, const VectorXd& values, const Scale& x, const Scale& y, Index stride) {
  std::string d;
  bool pen_up = true;
  for (Index i = 0; i < hours.size(); i += stride) {
    if (!std::isfinite(values[i])) {
      pen_up = true;
      continue;
    }
    d += fmt::format("{}{:.1f} {:.1f}", pen_up ? "M" : "L", x(hours[i]), y(values[i]));
    pen_up = false;
  }
  return d;
}

std::string band_path(const VectorXd& hours, const VectorXd& band, const Scale& x, const Scale& y, Index stride) {
  std::string upper, lower;
  for (Index i = 0; i < hours.size(); i += stride) {
    if (!std::isfinite(band[i])) continue;
    upper += fmt::format("{}{:.1f} {:.1f}", upper.empty() ? "M" : "L", x(hours[i]), y(band[i]));
    lower = fmt::format("L{:.1f} {:.1f}", x(hours[i]), y(-band[i])) + lower;
  }
  return upper.empty() ? "" : upper + lower + "Z";
}

std::string tick_text(double value, double step) {
  const int digits = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 6);
  const std::string text = fmt::format("{:.{}f}", std::abs(value) < 1e-9 * step ? 0.0 : value, digits);
  return text.starts_with('-') ? "\u2212" + text.substr(1) : text;
}

}  // namespace

std::string residual_map_svg(const ResidualMap& map) {
  constexpr double row = 15.0, name = 110.0, wide = 960.0, below = 34.0;
  constexpr Index most_columns = 120;
  const Index n = map.hours.size(), channels = map.ratio.cols(), columns = std::min(n, most_columns);
  if (n < 2 || channels == 0) return "";
  const double tall = row * channels;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"residuals of all channels over time\">\n", wide,
      tall + below);
  const double cell = (wide - name) / columns;
  for (Index c = 0; c < channels; ++c) {
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", name - 6, row * (c + 0.75),
                       core::xml_text(map.channels[c]));
    for (Index k = 0; k < columns; ++k) {
      double sum = 0.0;
      int count = 0;
      for (Index i = k * n / columns; i < (k + 1) * n / columns; ++i)
        if (std::isfinite(map.ratio(i, c))) sum += map.ratio(i, c), ++count;
      if (count == 0) continue;
      const double value = sum / count, strength = std::clamp((std::abs(value) - 1.0) / 7.0, 0.0, 1.0);
      svg += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.1f}\" fill=\"{}\" fill-opacity=\"{:.2f}\"/>",
          name + cell * k, row * c + 0.5, cell + 0.05, row - 1, value > 0 ? "#c4552d" : "#1b6ca8",
          0.06 + 0.94 * strength);
    }
    svg += "\n";
  }
  const Scale x{map.hours[0], map.hours[n - 1], name, wide};
  for (const double tick : core::axis_ticks(x.low, x.high, 8)) {
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{:.1f} {:.0f}v5\"/><text x=\"{:.1f}\" y=\"{:.0f}\" "
        "text-anchor=\"middle\">{:g}</text>",
        x(tick), tall, x(tick), tall + 17, tick);
  }
  svg += fmt::format("<path class=\"grid zero\" d=\"M{:.1f} 0V{:.0f}\"/>", x(map.heldout_from), tall);
  return svg + fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\">time in h</text></svg>\n",
                           0.5 * (name + wide), tall + 31);
}

std::string residual_svg(const ResidualPlot& plot) {
  const Index n = plot.hours.size();
  double low = 0.0, high = 0.0;
  for (const VectorXd* values : {&plot.before, &plot.after, &plot.band}) {
    for (const double v : *values)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  for (const double v : plot.band)
    if (std::isfinite(v)) low = std::min(low, -v);
  if (high - low < 1e-12) low = -1.0, high = 1.0;
  const double margin = 0.06 * (high - low);
  const double first = n > 0 ? plot.hours[0] : 0.0, last = n > 1 ? plot.hours[n - 1] : first + 1.0;
  const Scale x{first, last > first ? last : first + 1.0, left, width - right};
  const Scale y{low - margin, high + margin, height - bottom, top};
  const Index stride = std::max<Index>(1, n / most_points);

  std::string svg = fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"residual of {}\">\n",
                                width, height, core::xml_text(plot.title));
  const double split = std::clamp(plot.heldout_from, first, x.high);
  svg += fmt::format("<rect class=\"heldout\" x=\"{:.1f}\" y=\"{:.0f}\" width=\"{:.1f}\" height=\"{:.0f}\"/>\n",
                     x(split), top, x(x.high) - x(split), height - bottom - top);
  svg += fmt::format("<path class=\"band\" d=\"{}\"/>\n", band_path(plot.hours, plot.band, x, y, stride));
  const auto y_ticks = core::axis_ticks(y.low, y.high, 6), x_ticks = core::axis_ticks(x.low, x.high, 8);
  const double y_step = y_ticks.size() > 1 ? y_ticks[1] - y_ticks[0] : 1.0;
  const double x_step = x_ticks.size() > 1 ? x_ticks[1] - x_ticks[0] : 1.0;
  for (const double tick : y_ticks) {
    svg += fmt::format("<path class=\"grid{}\" d=\"M{:.0f} {:.1f}H{:.0f}\"/>",
                       std::abs(tick) < 1e-9 * y_step ? " zero" : "", left, y(tick), width - right);
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", left - 6, y(tick) + 3.5,
                       tick_text(tick, y_step));
  }
  for (const double tick : x_ticks) {
    svg += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.0f}v4\"/>", x(tick), height - bottom);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.0f}\" text-anchor=\"middle\">{}</text>\n", x(tick),
                       height - bottom + 16, tick_text(tick, x_step));
  }
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\">time in h</text>\n",
                     0.5 * (left + width - right), height - 4);
  svg += fmt::format("<text transform=\"translate(12 {:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     0.5 * (top + height - bottom), core::xml_text(plot.unit));
  svg += fmt::format("<path class=\"before\" d=\"{}\"/>\n", path(plot.hours, plot.before, x, y, stride));
  if (plot.show_after)
    svg += fmt::format("<path class=\"after\" d=\"{}\"/>\n", path(plot.hours, plot.after, x, y, stride));
  return svg + "</svg>\n";
}

}  // namespace thermotwin::diagnosis
