// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/load/rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/page_text.h"
#include "core/units.h"
#include "mesh/machine/cutting_fluid.h"
#include "solver/operation/channels.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

double unit_of(const mesh::Axis& axis) { return axis.kind == mesh::AxisKind::linear ? units::mm : units::deg; }
const char* unit_name(const mesh::Axis& axis) { return axis.kind == mesh::AxisKind::linear ? "mm" : "deg"; }

/// The range that a row states: an endless axis goes round at most once, a limited one stays within its travel.
std::pair<double, double> range_of(const mesh::Axis& axis, const Row& row, Eigen::Index i) {
  double low = row.low[i], high = row.high[i];
  if (axis.endless && high - low > 2.0 * std::numbers::pi) high = low + 2.0 * std::numbers::pi;
  if (!axis.endless) {
    low = std::clamp(low, axis.low, axis.high);
    high = std::clamp(high, axis.low, axis.high);
  }
  return {low, high};
}

}  // namespace

RowBuilder::RowBuilder(Positions start, double interval, ProcessHeat& process, std::function<void(const Row&)> take)
    : interval_(interval),
      process_(process),
      take_(std::move(take)),
      at_(std::move(start)) {
  travel_ = Positions::Zero(at_.size());
  direction_ = Positions::Constant(at_.size(), solver::either_direction);
  begin();
}

void RowBuilder::begin() {
  const double from = row_.to;
  row_ = Row{};
  fastest_rpm_ = 0.0;
  row_.from = row_.to = from;
  row_.travel = row_.positive = Positions::Zero(at_.size());
  row_.low = row_.high = row_.end = at_;
  row_.process_W = Eigen::VectorXd::Zero(std::ssize(process_.drives()));
}

void RowBuilder::close(double to) {
  row_.to = to;
  const double duration = to - row_.from;
  if (!(duration > 0.0)) return;
  // No mean is above its largest value, whatever the rounding: the machine may allow no more.
  row_.spindle_rpm = std::min(row_.spindle_rpm / duration, fastest_rpm_);
  row_.fluid = std::min(1.0, row_.fluid / duration);
  row_.process_W /= duration;
  row_.positive /= duration;
  row_.end = at_;
  travel_ += row_.travel;
  take_(row_);
  begin();
}

void RowBuilder::stretch(const Timed& timed, double from, double to) {
  const Element& element = timed.element;
  const double duration = to - from;
  const double rpm = std::abs(element.state.spindle_rpm);
  row_.spindle_rpm += rpm * duration;
  fastest_rpm_ = std::max(fastest_rpm_, rpm);
  if (element.state.flood || element.state.mist) row_.fluid += duration;
  process_.add(timed, from, to, row_.process_W);
  if (!(element.pause > 0.0)) {
    // Exactly whole: sums of times carry rounding.
    const double u0 = from > timed.start ? timed.share_at(from - timed.start) : 0.0,
                 u1 = to < timed.start + timed.duration() ? timed.share_at(to - timed.start) : 1.0;
    element.sweep(u0, u1, row_.travel, row_.low, row_.high);
    const Positions now = element.at(u1);
    for (Eigen::Index i = 0; i < now.size(); ++i)
      if (now[i] != at_[i]) direction_[i] = now[i] > at_[i] ? 1.0 : 0.0;
    at_ = now;
  }
  row_.positive += duration * direction_;
}

void RowBuilder::add(const Timed& timed) {
  const double end = timed.start + timed.duration();
  double from = timed.start;
  const double rounding = 1e-12 * end;
  while (end - (row_.from + interval_) > -rounding) {
    // A rest of rounding makes no row of its own.
    const double full = row_.from + interval_, boundary = end - full > rounding ? full : end;
    stretch(timed, from, boundary);
    from = boundary;
    close(boundary);
    if (!(end > boundary)) return;
  }
  stretch(timed, from, end);
  row_.to = end;
}

void RowBuilder::finish() { close(row_.to); }

std::string rows_header(const mesh::Machine& machine, const std::vector<std::string>& drives) {
  std::string text =
      fmt::format("# machine {} {}\ntime_s,spindle.speed_rpm,cutting_fluid.on", machine.name, machine.hash);
  for (const std::string& drive : drives) text += fmt::format(",{}.power_W", drive);
  for (const mesh::Axis& axis : machine.axes) {
    const char* unit = unit_name(axis);
    text +=
        fmt::format(",axis.{0}.position_{1},axis.{0}.feed_{1}_min,axis.{0}.low_{1},axis.{0}.high_{1}", axis.id, unit);
    if (machine.has_direction(axis.id)) text += fmt::format(",axis.{}.positive.on", axis.id);
  }
  return text + "\n";
}

std::string first_row_text(const mesh::Machine& machine, const std::vector<std::string>& drives, const Positions& start,
                           double clock) {
  std::string text = fmt::format("{},0,0", clock);
  for (std::size_t i = 0; i < drives.size(); ++i) text += ",0";
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    text += fmt::format(",{},0,,", start[i] / unit_of(machine.axes[i]));
    if (machine.has_direction(machine.axes[i].id)) text += fmt::format(",{}", solver::either_direction);
  }
  return text + "\n";
}

std::string row_text(const mesh::Machine& machine, const Row& row, double clock) {
  std::string text = fmt::format("{},{},{}", clock + row.to, row.spindle_rpm, row.fluid);
  for (const double power : row.process_W) text += fmt::format(",{}", power);
  for (std::size_t k = 0; k < machine.axes.size(); ++k) {
    const Eigen::Index i = k;
    const mesh::Axis& axis = machine.axes[k];
    const double unit = unit_of(axis), feed = row.travel[i] / (row.to - row.from) * units::minute;
    const auto [low, high] = range_of(axis, row, i);
    text += fmt::format(",{},{}", row.end[i] / unit, feed / unit);
    // An axis that stands has no range.
    text += high > low ? fmt::format(",{},{}", low / unit, high / unit) : std::string(",,");
    if (machine.has_direction(axis.id)) text += fmt::format(",{}", row.positive[i]);
  }
  return text + "\n";
}

Eigen::VectorXd row_channels(const mesh::Machine& machine, const std::vector<std::string>& names,
                             const std::vector<std::string>& drives, const Row& row) {
  Eigen::VectorXd values = Eigen::VectorXd::Constant(std::ssize(names), std::numeric_limits<double>::quiet_NaN());
  const auto set = [&](const std::string& name, double value) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) values[found - names.begin()] = value;
  };
  set("spindle.speed_rpm", row.spindle_rpm);
  set("cutting_fluid.on", row.fluid);
  for (Eigen::Index i = 0; i < row.process_W.size(); ++i) set(drives[i] + ".power_W", row.process_W[i]);
  for (std::size_t k = 0; k < machine.axes.size(); ++k) {
    const Eigen::Index i = k;
    const mesh::Axis& axis = machine.axes[k];
    const std::string prefix = "axis." + axis.id + ".", unit = unit_name(axis);
    const double in_unit = unit_of(axis);
    const auto [low, high] = range_of(axis, row, i);
    set(prefix + "position_" + unit, row.end[i] / in_unit);
    if (row.positive.size() > 0) set(prefix + "positive.on", row.positive[i]);
    set(prefix + "feed_" + unit + "_min", row.travel[i] / (row.to - row.from) * units::minute / in_unit);
    if (high > low) {
      set(prefix + "low_" + unit, low / in_unit);
      set(prefix + "high_" + unit, high / in_unit);
    }
  }
  return values;
}

LoadText::LoadText(const mesh::Machine& machine, const std::vector<std::string>& drives, const std::string& title,
                   double initial_C, const Positions& start)
    : machine_(machine),
      drives_(drives),
      has_fluid_(mesh::has_cutting_fluid(machine)) {
  head_ = fmt::format("# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\ntitle = {}\ninitial_C = {}\n",
                      core::json_text(title), initial_C);
  phases_ = "[position]\n";
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const mesh::Axis& axis = machine.axes[i];
    phases_ += fmt::format("{}_{} = {}\n", axis.id, unit_name(axis), start[i] / unit_of(axis));
  }
}

void LoadText::add(const Row& row) {
  const double duration = row.to - row.from;
  phases_ += fmt::format("[[phase]]\nduration_s = {}\nspindle_rpm = {}\ncutting_fluid = {}\n", duration,
                         row.spindle_rpm, row.fluid >= 0.5 && has_fluid_ ? "true" : "false");
  for (Eigen::Index i = 0; i < row.process_W.size(); ++i)
    phases_ += fmt::format("\"{}_W\" = {}\n", drives_[i], row.process_W[i]);
  for (std::size_t k = 0; k < machine_.axes.size(); ++k) {
    const Eigen::Index i = k;
    const mesh::Axis& axis = machine_.axes[k];
    const char* name = unit_name(axis);
    const double unit = unit_of(axis);
    const auto [low, high] = range_of(axis, row, i);
    phases_ += fmt::format("[[phase.axis]]\nid = \"{}\"\n", axis.id);
    if (high > low)
      phases_ += fmt::format("low_{0} = {1}\nhigh_{0} = {2}\nfeed_{0}_min = {3}\n", name, low / unit, high / unit,
                             row.travel[i] / duration * units::minute / unit);
    else
      phases_ += fmt::format("position_{} = {}\n", name, row.end[i] / unit);
  }
}

std::string LoadText::finish(double interval) {
  return head_ + fmt::format("time_step_s = {0}\noutput_s = {0}\n", interval) + phases_;
}

}  // namespace thermotwin::nc
