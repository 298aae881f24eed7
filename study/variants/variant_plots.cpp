// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/variant_plots.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/html_page.h"
#include "core/plot.h"
#include "core/units.h"

namespace thermotwin::study {

using core::Ink;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

struct Curve {
  VectorXd low, middle, high;
};

VectorXd at_pose(const core::Table& table, const std::string& column, Index pose, Index poses) {
  const VectorXd all = table.column(column);
  const Index times = table.rows() / poses;
  VectorXd values(times);
  for (Index t = 0; t < times; ++t) values[t] = all[t * poses + pose];
  return values;
}

}  // namespace

std::string quantiles_svg(const LoadStudy& load, Index pose, Index poses) {
  const VectorXd hours = at_pose(load.quantiles, "time_s", pose, poses) / core::units::hour;
  const struct {
    const char *column, *title;
    Ink ink;
  } parts[] = {{"error_um", "length", Ink::black},
               {"dx_um", "X", Ink::blue},
               {"dy_um", "Y", Ink::orange},
               {"dz_um", "Z", Ink::green}};
  core::Axis time{"time, h"}, error{"TCP error, um"};
  time.include(hours);
  time.close();
  std::vector<Curve> curves;
  for (const auto& part : parts) {
    const std::string name = part.column;
    curves.push_back({at_pose(load.quantiles, name + "_q05", pose, poses),
                      at_pose(load.quantiles, name + "_q50", pose, poses),
                      at_pose(load.quantiles, name + "_q95", pose, poses)});
    error.include(curves.back().low);
    error.include(curves.back().high);
  }
  error.close(0.05);
  core::Plot plot(820, 360, "TCP error over time, median and 5 to 95 %");
  core::Panel panel(plot, {64, 34, 730, 270}, time, error);
  panel.y_axis();
  panel.x_axis();
  double right = 64;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    panel.band(hours, curves[i].low, curves[i].high);
    panel.line(hours, curves[i].middle, parts[i].ink);
    right = plot.key(right, 18, parts[i].title, parts[i].ink);
  }
  return core::html_wide(900, plot.inset());
}

std::string shares_svg(const std::vector<std::string>& names, const Sensitivity& sensitivity, std::size_t most) {
  std::vector<std::size_t> order = by_total(sensitivity);
  if (order.size() > most) order.resize(most);
  const double rows = order.size();
  core::Axis share{"share of the variance", false, 0.0, 1.0}, down{"", false, rows, 0.0};
  const double height = 26.0 * rows;
  core::Plot plot(900, height + 84, "first-order and total share of each parameter");
  plot.key(plot.key(300, 18, "first order", Ink::blue), 18, "total", Ink::orange);
  core::Panel panel(plot, {300, 30, 560, height}, share, down);
  panel.x_axis(true);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Share &first = sensitivity.first[order[k]], &total = sensitivity.total[order[k]];
    const double at = k;
    panel.box(0.0, std::clamp(first.value, 0.0, 1.0), at + 0.12, at + 0.48, Ink::blue, 0.6);
    panel.stroke(first.low, at + 0.30, first.high, at + 0.30, Ink::blue);
    panel.box(0.0, std::clamp(total.value, 0.0, 1.0), at + 0.52, at + 0.88, Ink::orange, 0.6);
    panel.stroke(total.low, at + 0.70, total.high, at + 0.70, Ink::orange);
    plot.text(292, panel.y(at + 0.62), names[order[k]], core::Anchor::end);
  }
  return core::html_wide(980, plot.inset());
}

}  // namespace thermotwin::study
