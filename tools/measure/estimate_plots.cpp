// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/estimate_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/plot.h"
#include "core/units.h"

namespace thermotwin::tools {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
namespace units = core::units;

constexpr std::size_t most_series = 8;

VectorXd series_of(const metrology::Estimates& estimates, std::size_t error, bool expanded) {
  VectorXd values(std::ssize(estimates.cycles));
  for (Index i = 0; i < values.size(); ++i) {
    const metrology::CycleResult& cycle = estimates.cycles[i];
    const auto e = error;
    values[i] = (expanded ? 2.0 * cycle.std[e] : cycle.value[e]) / units::um;
  }
  return values;
}

double range_of(const VectorXd& values) { return values.maxCoeff() - values.minCoeff(); }

std::vector<std::size_t> widest_of_unit(const metrology::Estimates& estimates, const std::string& unit) {
  std::vector<std::size_t> errors;
  for (const std::size_t e : estimates.observed())
    if (estimates.units[e] == unit) errors.push_back(e);
  std::vector<double> ranges(estimates.errors.size(), 0.0);
  for (const std::size_t e : errors) ranges[e] = range_of(series_of(estimates, e, false));
  if (errors.size() > most_series) {
    std::stable_sort(errors.begin(), errors.end(), [&](auto a, auto b) { return ranges[a] > ranges[b]; });
    errors.resize(most_series);
    std::sort(errors.begin(), errors.end());
  }
  return errors;
}

/// Rows of the last cycle of a table with a column "cycle".
core::Table last_cycle(const core::Table& table) {
  const VectorXd cycle = table.column("cycle");
  std::vector<Index> rows;
  for (Index i = 0; i < cycle.size(); ++i)
    if (cycle[i] == cycle[cycle.size() - 1]) rows.push_back(i);
  core::Table last = table;
  last.values = table.values(rows, Eigen::all).eval();
  return last;
}

}  // namespace

std::string over_time(const metrology::Estimates& estimates, const std::string& name) {
  if (estimates.cycles.size() < 2) return "";
  std::vector<std::string> kinds;
  for (const std::size_t e : estimates.observed())
    if (std::find(kinds.begin(), kinds.end(), estimates.units[e]) == kinds.end()) kinds.push_back(estimates.units[e]);
  VectorXd hours(std::ssize(estimates.cycles));
  for (Index i = 0; i < hours.size(); ++i)
    hours[i] = (estimates.cycles[i].time - estimates.cycles.front().time) / units::hour;
  constexpr double width = 860, panel_height = 240, step = 330;
  core::Plot plot(width, 20 + step * kinds.size(), name);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const std::vector<std::size_t> errors = widest_of_unit(estimates, kinds[k]);
    core::Axis x{"time, h"}, y{kinds[k]};
    x.include(hours);
    for (const std::size_t e : errors) {
      const VectorXd values = series_of(estimates, e, false), band = series_of(estimates, e, true);
      y.include(values - band);
      y.include(values + band);
    }
    x.close();
    y.close(0.05);
    const double top = 60 + step * k;
    plot.title(70, top - 34, name + ", " + kinds[k] + ", with U (k = 2)");
    core::Panel panel(plot, {70, top, width - 100, panel_height}, x, y);
    panel.x_axis();
    panel.y_axis();
    double key = 70;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const VectorXd values = series_of(estimates, errors[i], false), band = series_of(estimates, errors[i], true);
      panel.band(hours, values - band, values + band);
      panel.line(hours, values, core::series_ink(i));
      key = plot.key(key, top - 14, estimates.errors[errors[i]], core::series_ink(i));
    }
  }
  return plot.file();
}

std::string residual_picture(const core::Table& residuals) {
  const core::Table last = last_cycle(residuals);
  const VectorXd at[] = {last.column("x_mm"), last.column("y_mm"), last.column("z_mm")};
  const VectorXd of[] = {last.column("rx_um"), last.column("ry_um"), last.column("rz_um")};
  double largest = 0.0;
  for (Index i = 0; i < last.rows(); ++i) largest = std::max(largest, std::hypot(of[0][i], of[1][i], of[2][i]));
  double extent = 0.0;
  for (const VectorXd& values : at) extent = std::max(extent, range_of(values));
  const double scale = largest > 0 ? 0.12 * extent / largest : 0.0;  // mm per um
  constexpr double side = 300, step = 390;
  core::Plot plot(3 * step + 20, 420, "residuals of the last cycle");
  plot.title(70, 24, fmt::format("residuals of the last cycle; the longest is {:.3g} um", largest));
  constexpr int planes[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int p = 0; p < 3; ++p) {
    const int a = planes[p][0], b = planes[p][1];
    const auto square = [&](int axis) {
      core::Axis shown{fmt::format("{}, mm", "xyz"[axis])};
      const double middle = 0.5 * (at[axis].maxCoeff() + at[axis].minCoeff());
      shown.include(middle - 0.65 * extent);
      shown.include(middle + 0.65 * extent);
      shown.close();
      return shown;
    };
    core::Panel panel(plot, {70 + step * p, 50, side, side}, square(a), square(b));
    panel.x_axis();
    panel.y_axis();
    for (Index i = 0; i < last.rows(); ++i)
      panel.stroke(at[a][i], at[b][i], at[a][i] + scale * of[a][i], at[b][i] + scale * of[b][i], core::Ink::orange);
    panel.dots(at[a], at[b], core::Ink::blue);
  }
  return plot.file();
}

std::string surface_picture(const core::Table& map, const core::Table& points) {
  const core::Table last = last_cycle(map), measured = last_cycle(points);
  const VectorXd x = last.column("x_mm"), y = last.column("y_mm");
  const double radius = x.maxCoeff();
  VectorXd places = x;
  std::sort(places.begin(), places.end());
  double half = radius;
  for (Index i = 1; i < places.size(); ++i)
    if (places[i] - places[i - 1] > 1e-9 * radius) half = std::min(half, 0.5 * (places[i] - places[i - 1]));
  constexpr double side = 340, step = 440;
  core::Plot plot(2 * step, 440, "deformation of the table's surface, last cycle");
  const char* columns[] = {"height_um", "bending_um"};
  for (int k = 0; k < 2; ++k) {
    VectorXd height = last.column(columns[k]);
    const double mean = k == 0 ? height.mean() : 0.0;
    height.array() -= mean;
    const double largest = height.cwiseAbs().maxCoeff();
    const double left = 70 + step * k;
    plot.title(left, 24,
               k == 0 ? fmt::format("height less its mean of {:.3g} um", mean) : std::string("without the plane"));
    plot.text(left, 42,
              fmt::format("blue: down to {:.3g} um; orange: up to {:.3g} um", height.minCoeff(), height.maxCoeff()));
    core::Axis across{"x, mm"}, up{"y, mm"};
    for (core::Axis* axis : {&across, &up}) {
      axis->include(-1.08 * radius);
      axis->include(1.08 * radius);
      axis->close();
    }
    core::Panel panel(plot, {left, 54, side, side}, across, up);
    panel.x_axis();
    panel.y_axis();
    for (Index i = 0; i < height.size(); ++i) {
      const double share = largest > 0 ? std::abs(height[i]) / largest : 0.0;
      panel.box(x[i] - half, x[i] + half, y[i] - half, y[i] + half, height[i] < 0 ? core::Ink::blue : core::Ink::orange,
                share);
    }
    panel.dots(measured.column("x_mm"), measured.column("y_mm"), core::Ink::black);
  }
  return plot.file();
}

}  // namespace thermotwin::tools
