// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/validation_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/html_page.h"

namespace thermotwin::compensation {
namespace {

using core::Ink;
using Eigen::Index;
using Eigen::VectorXd;

std::vector<double> finite(const std::vector<double>& values) {
  std::vector<double> kept;
  std::copy_if(values.begin(), values.end(), std::back_inserter(kept), [](double v) { return std::isfinite(v); });
  return kept;
}

/// Machines side by side, so that equal ones do not hide each other.
void draw_column(core::Panel& panel, double at, const DotColumn& column) {
  const std::vector<double> values = finite(column.values);
  if (values.empty()) return;
  const auto count = std::ssize(values);
  if (count > 2)
    panel.box(at - 0.32, at + 0.32, core::quantile(values, 0.1), core::quantile(values, 0.9), column.ink, 0.16);
  VectorXd places(count), heights(count);
  for (Index i = 0; i < count; ++i) {
    places[i] = at + (count > 1 ? 0.5 * (i / (count - 1.0) - 0.5) : 0.0);
    heights[i] = values[i];
  }
  panel.dots(places, heights, column.ink);
  const double median = core::quantile(values, 0.5);
  panel.stroke(at - 0.36, median, at + 0.36, median, column.ink);
}

}  // namespace

std::string dots_svg(const std::string& name, const std::string& y_title, const std::vector<DotColumn>& columns) {
  core::Axis value{y_title};
  std::vector<double> places;  // a gap of one between groups
  double right = 0.5;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0 && columns[i].group != columns[i - 1].group) right += 0.8;
    places.push_back(right + 0.5);
    right += 1.0;
    for (const double v : finite(columns[i].values)) value.include(v);
  }
  value.close(0.08);
  const core::Axis across{"", false, 0.0, right + 0.5};
  const double width = std::max(540.0, 30.0 + 124.0 * right);
  core::Plot plot(width + 80.0, 358, name);
  core::Panel panel(plot, {64, 26, width, 280}, across, value);
  panel.y_axis();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    draw_column(panel, places[i], columns[i]);
    plot.text(panel.x(places[i]), 324, columns[i].name, core::Anchor::middle);
    const std::vector<double> values = finite(columns[i].values);
    if (!values.empty())
      plot.text(panel.x(places[i]), 18, fmt::format("{:.1f}", core::quantile(values, 0.5)), core::Anchor::middle);
  }
  for (std::size_t first = 0, last = 0; first < columns.size(); first = last) {
    while (last < columns.size() && columns[last].group == columns[first].group) ++last;
    plot.text(panel.x(0.5 * (places[first] + places[last - 1])), 346, columns[first].group, core::Anchor::middle);
  }
  return core::html_wide(static_cast<int>(width) + 160, plot.inset());
}

std::string removal_svg(const Validation& validation) {
  std::vector<std::string> loads;
  for (const ValidationRow& row : validation.rows)
    if (std::find(loads.begin(), loads.end(), row.load) == loads.end()) loads.push_back(row.load);
  std::vector<DotColumn> columns;
  for (const std::string& load : loads) {
    columns.push_back({load, "no sensors", validation.reductions(load, With::model), Ink::grey});
    columns.push_back({load, "surroundings known", validation.reductions(load, With::told), Ink::orange});
    columns.push_back({load, "sensors", validation.reductions(load, With::sensors), Ink::blue});
  }
  return dots_svg("RMS of the TCP error removed on each machine", "RMS removed in %", columns);
}

std::string trace_svg(const ValidationTrace& trace) {
  constexpr double height = 120.0, apart = 146.0, top = 26.0;
  core::Axis time{"", false};
  time.include(trace.hours);
  time.close();
  core::Plot plot(1080, 3 * apart + 16 + top,
                  fmt::format("TCP error at {}, before and after compensation", trace.pose));
  constexpr const char* names[] = {"X in \u00b5m", "Y in \u00b5m", "Z in \u00b5m"};
  const Eigen::Matrix3Xd bands = trace.band_um();
  plot.text(64, 14, "without and with compensation");
  plot.text(690, 14, "with compensation, enlarged, and its uncertainty");
  for (int k = 0; k < 3; ++k) {
    const VectorXd before = trace.before_um.row(k), left = trace.left_um.row(k), band = bands.row(k);
    core::Axis error{names[k]}, rest{""};
    error.include(0.0);
    for (const VectorXd& values : {before, left}) error.include(values);
    for (const VectorXd& values : {left, band, VectorXd(-band)}) rest.include(values);
    error.close(0.06);
    rest.close(0.06);
    if (k == 2) time.title = "time in h";
    core::Panel both(plot, {64, top + apart * k, 560, height}, time, error),
        after(plot, {690, top + apart * k, 376, height}, time, rest);
    after.band(trace.hours, -band, band);
    for (core::Panel* panel : {&both, &after}) {
      panel->y_axis();
      panel->x_axis();
    }
    both.line(trace.hours, before, Ink::orange);
    both.line(trace.hours, left, Ink::blue);
    after.line(trace.hours, left, Ink::blue);
  }
  return plot.inset();
}

std::string trace_legend() {
  return "<div class=\"legend\"><span><i class=\"orange\"></i>measured, without compensation</span><span><i "
         "class=\"blue\"></i>with compensation (sensors)</span><span><i class=\"band\"></i>± 2 standard deviations, "
         "of the offsets as the compensator states them (its std_um) and of the measured values</span></div>\n";
}

}  // namespace thermotwin::compensation
