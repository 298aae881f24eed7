// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/line_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/svg.h"

namespace thermotwin::core {
namespace {

constexpr double width = 760, height = 460, left = 78, right = 150, top = 44, bottom = 54;
/// Colours that differ in lightness as well (Okabe & Ito).
constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#e69f00", "#56b4e9", "#8c8c00", "#7f7f7f"};

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return !(low <= high); }
};

/// Path and dots of the points; a point without a place leaves a gap.
template <class Points, class Place>
std::pair<std::string, std::string> polyline(const Points& points, const Place& place) {
  std::string path, dots;
  bool pen_up = true;
  for (const auto& [at, value] : points) {
    const auto here = place(at, value);
    if (here) {
      path += fmt::format("{}{:.1f} {:.1f}", pen_up ? "M" : "L", here->first, here->second);
      dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\"/>", here->first, here->second);
    }
    pen_up = !here;
  }
  return {path, dots};
}

}  // namespace

std::string LineChart::svg() const {
  const auto usable = [&](double y) { return std::isfinite(y) && (!log_y || y > 0.0); };
  const auto on_axis = [&](double y) { return log_y ? std::log10(y) : y; };
  Extent x, y;
  for (const Line& line : lines) {
    for (const auto& [at, value] : line.points)
      if (std::isfinite(at) && usable(value)) x.include(at), y.include(on_axis(value));
  }
  if (usable(target)) y.include(on_axis(target));
  if (x.empty()) x.include(0.0), x.include(1.0);
  if (y.empty()) y.include(0.0), y.include(1.0);
  if (x.high - x.low < 1e-12) x.low -= 0.5, x.high += 0.5;
  if (log_y) y.low = std::floor(y.low), y.high = std::ceil(y.high);
  if (y.high - y.low < 1e-12) y.low -= 0.5, y.high += 0.5;
  if (!log_y) y.include(y.low - 0.04 * (y.high - y.low)), y.include(y.high + 0.04 * (y.high - y.low));
  const auto px = [&](double at) { return left + (at - x.low) / (x.high - x.low) * (width - left - right); };
  const auto py = [&](double value) {
    return height - bottom - (value - y.low) / (y.high - y.low) * (height - top - bottom);
  };

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "role=\"img\" "
      "aria-label=\"{2}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n<rect width=\"100%\" "
      "height=\"100%\" fill=\"#fff\"/>\n"
      "<text x=\"{3:.0f}\" y=\"26\" font-size=\"16\">{2}</text>\n",
      width, height, xml_text(title), left);
  const auto grid_line = [&](double value, const std::string& text) {
    svg += fmt::format(
        "<path d=\"M{:.0f} {:.1f}H{:.0f}\" stroke=\"#ddd\"/><text x=\"{:.0f}\" y=\"{:.1f}\" "
        "text-anchor=\"end\">{}</text>\n",
        left, py(value), width - right, left - 8, py(value) + 4, text);
  };
  if (log_y) {
    for (double power = y.low; power <= y.high + 1e-9; ++power)
      grid_line(power, fmt::format("{:g}", std::pow(10.0, power)));
  } else {
    for (const double tick : axis_ticks(y.low, y.high, 6))
      grid_line(tick, fmt::format("{:g}", std::abs(tick) < 1e-12 ? 0.0 : tick));
  }
  for (const double tick : axis_ticks(x.low, x.high, 8)) {
    svg += fmt::format(
        "<path d=\"M{:.1f} {:.0f}v5\" stroke=\"#222\"/><text x=\"{:.1f}\" y=\"{:.0f}\" "
        "text-anchor=\"middle\">{:g}</text>\n",
        px(tick), height - bottom, px(tick), height - bottom + 20, tick);
  }
  svg += fmt::format("<path d=\"M{:.0f} {:.0f}H{:.0f}\" stroke=\"#222\"/>\n", left, height - bottom, width - right);
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\">{}</text>\n", 0.5 * (left + width - right),
                     height - 12, xml_text(x_title));
  svg += fmt::format("<text transform=\"translate(18 {:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     0.5 * (top + height - bottom), xml_text(y_title));
  if (usable(target)) {
    const double at = py(on_axis(target));
    svg += fmt::format(
        "<path d=\"M{:.0f} {:.1f}H{:.0f}\" stroke=\"#222\" stroke-dasharray=\"6 4\"/><text x=\"{:.0f}\" "
        "y=\"{:.1f}\">{}</text>\n",
        left, at, width - right, width - right + 8, at + 4, xml_text(target_name));
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const char* colour = colours[i % std::size(colours)];
    const auto [path, dots] = polyline(lines[i].points, [&](double at, double value) {
      return std::isfinite(at) && usable(value) ? std::optional(std::pair(px(at), py(on_axis(value)))) : std::nullopt;
    });
    svg += fmt::format("<g fill=\"{0}\"><path d=\"{1}\" fill=\"none\" stroke=\"{0}\" stroke-width=\"2\"/>{2}</g>\n",
                       colour, path, dots);
    const double at = top + 10 + 22.0 * i;
    svg += fmt::format(
        "<path d=\"M{0:.0f} {1:.0f}h20\" stroke=\"{2}\" stroke-width=\"3\"/><text x=\"{3:.0f}\" "
        "y=\"{4:.0f}\">{5}</text>\n",
        width - right + 10, at, colour, width - right + 36, at + 4, xml_text(lines[i].name));
  }
  return svg + "</svg>\n";
}

}  // namespace thermotwin::core
