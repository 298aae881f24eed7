// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/imprint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/html_page.h"
#include "core/plot.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "nc/report/time_text.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

/// The filled intervals of a curve.
struct Curve {
  Eigen::VectorXd time;                            ///< in a unit
  std::array<Eigen::VectorXd, 3> mean, low, high;  ///< um

  /// Intervals are joined where they are more than a curve needs.
  Curve(const ErrorOverTime& errors, double unit) {
    constexpr std::size_t most = 300;
    const auto& all = errors.intervals();
    const std::size_t joined = (all.size() + most - 1) / most;
    std::vector<std::pair<double, ErrorOverTime::Interval>> filled;  // middle
    for (std::size_t i = 0; i < all.size(); i += joined) {
      ErrorOverTime::Interval sum;
      const std::size_t end = std::min(all.size(), i + joined);
      for (std::size_t k = i; k < end; ++k) sum.add(all[k]);
      if (sum.count > 0) filled.emplace_back(0.5 * (i + end) * errors.width() / unit, sum);
    }
    const auto count = std::ssize(filled);
    time.resize(count);
    for (auto* values : {&mean, &low, &high}) values->fill(Eigen::VectorXd(count));
    for (Eigen::Index at = 0; const auto& [middle, interval] : filled) {
      time[at] = middle;
      for (std::size_t c = 0; c < 3; ++c) {
        const Eigen::Index component = c;
        mean[c][at] = interval.sum[component] / interval.count;
        low[c][at] = interval.low[component];
        high[c][at] = interval.high[component];
      }
      ++at;
    }
  }
};

core::Plot drawing(const Imprint& imprint) {
  double end = 0.0;
  for (const auto& [line, block] : imprint.blocks()) end = std::max(end, block.to_s);
  const TimeUnit unit = unit_for(end);
  const Curve pass(imprint.pass(), unit.seconds);
  std::vector<Curve> curves;
  for (const auto& [line, errors] : imprint.curves()) curves.emplace_back(errors, unit.seconds);
  constexpr double height = 140.0, apart = 166.0, top = 34.0;
  core::Plot plot(1080, top + 3 * apart + 16, "Error that the finishing pass leaves in the surface, over time");
  double at = 64.0;
  for (std::size_t k = 0; const auto& [line, errors] : imprint.curves())
    at = plot.key(at, 18, fmt::format("line {}", line), core::series_ink(k++)) + 14;
  core::Axis across{"", false};
  across.include(pass.time);
  across.close();
  constexpr const char* names[] = {"X in \u00b5m", "Y in \u00b5m", "Z in \u00b5m"};
  for (std::size_t c = 0; c < 3; ++c) {
    core::Axis error{names[c]};
    error.include(0.0);
    error.include(pass.low[c]);
    error.include(pass.high[c]);
    error.close(0.06);
    if (c == 2) across.title = fmt::format("time in {}", unit.name);
    core::Panel panel(plot, {64, top + apart * c, 1000, height}, across, error);
    panel.band(pass.time, pass.low[c], pass.high[c]);
    panel.y_axis();
    panel.x_axis();
    for (std::size_t k = 0; k < curves.size(); ++k) panel.line(curves[k].time, curves[k].mean[c], core::series_ink(k));
    if (curves.empty()) panel.line(pass.time, pass.mean[c], core::Ink::blue);
  }
  return plot;
}

}  // namespace

Imprint::Imprint(const AxisMotion& motion, int tool)
    : machine_(motion.machine()),
      tool_(tool),
      body_(machine_.body_index(machine_.tcp.table_body)),
      samples_(motion, [this](const PathPoint& point, const Positions& positions) { take(point, positions); }) {}

std::string Imprint::add(const PredictedMove& move) {
  const Element& element = move.timed->element;
  if (element.rapid || element.state.tool != tool_ || !element.source) return "";
  Block& block = blocks_[element.state.line];
  if (block.runs++ == 0) block.from_s = move.time;
  block.to_s = move.time;
  if (move.start > end_s_ * (1.0 + 1e-12)) samples_.restart();
  end_s_ = move.time;
  if (blocks_.size() > most_curves) curves_.clear();
  rows_.clear();
  samples_.add(move);
  return rows_;
}

void Imprint::take(PathPoint point, const Positions& positions) {
  point.error_um = mesh::body_transform(machine_, body_, positions).linear().transpose() * point.error_um;
  Block& block = blocks_[point.line];
  const Eigen::Array3d error = point.error_um.array();
  block.error.add({1, error, error, error, point.std_um.array()});
  pass_.add(point);
  if (blocks_.size() <= most_curves) curves_[point.line].add(point);
  const Eigen::Vector3d place = point.place / units::mm;
  rows_ += fmt::format("{},{},{:.3f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", point.line, block.runs, point.time,
                       place[0], place[1], place[2], error[0], error[1], error[2]);
}

std::vector<std::vector<std::string>> imprint_table(const Imprint& imprint, std::size_t most) {
  std::vector<std::vector<std::string>> rows{{"line", "runs", "from", "to"}};
  for (const char* axis : {"X", "Y", "Z"})
    for (const char* what : {"mean", "smallest", "largest"})
      rows.front().push_back(fmt::format("{} {} um", axis, what));
  for (const auto& [line, block] : imprint.blocks()) {
    if (rows.size() > most) break;
    rows.push_back({std::to_string(line), std::to_string(block.runs), time_text(block.from_s), time_text(block.to_s)});
    for (int c = 0; c < 3; ++c)
      for (const double value : {block.error.sum[c] / block.error.count, block.error.low[c], block.error.high[c]})
        rows.back().push_back(fmt::format("{:.2f}", value));
  }
  return rows;
}

std::string imprint_svg(const Imprint& imprint) { return drawing(imprint).file(); }

std::string imprint_section(const Imprint& imprint, std::size_t most) {
  if (imprint.blocks().empty()) return "";
  std::string below;
  if (imprint.blocks().size() > most)
    below = fmt::format("<p class=\"below\">{} of {} lines; imprint.csv has all.</p>\n", most, imprint.blocks().size());
  return core::html_section(
      "Imprint of the finishing pass",
      fmt::format("tool T{}: error that stays in the surface, tool against workpiece, in the directions of the "
                  "workpiece; band: smallest to largest of all cuts",
                  imprint.tool()),
      drawing(imprint).inset() + core::html_table(imprint_table(imprint, most)) + below);
}

}  // namespace thermotwin::nc
