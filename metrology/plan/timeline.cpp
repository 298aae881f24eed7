// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {

namespace units = core::units;
using Eigen::Index;
using mesh::Axis;
using mesh::AxisKind;
using mesh::Pose;

namespace {

constexpr double turn_rad = 2.0 * std::numbers::pi;
constexpr double still = 1e-10;  ///< m or rad

double unit_of(const Axis& axis) { return axis.kind == AxisKind::linear ? units::mm : units::deg; }
std::string unit_name(const Axis& axis) { return axis.kind == AxisKind::linear ? "mm" : "deg"; }

/// 1.5 -> "1.5", 2 -> "2.": a number with a point, as NC programs have it.
std::string nc_number(double value) {
  std::string text = fmt::format("{:.6f}", std::abs(value) < 5e-7 ? 0.0 : value);
  while (text.back() == '0') text.pop_back();
  return text;
}

/// The position of an endless axis within a turn.
double wrapped(double angle) {
  const double rest = angle - turn_rad * std::floor(angle / turn_rad);
  return rest > turn_rad - 1e-9 ? 0.0 : rest;
}

}  // namespace

Timeline::Timeline(const mesh::Machine& machine, Pose start, std::string place)
    : machine_(machine),
      pose_(std::move(start)),
      place_(std::move(place)) {
  require_in_travel(pose_);
}

double Timeline::fastest(int axis) const { return machine_.axes[axis].rapid > 0 ? machine_.axes[axis].rapid : 1.0; }

void Timeline::require_in_travel(const Pose& target) const {
  for (Index i = 0; i < target.size(); ++i) {
    const Axis& axis = machine_.axes[i];
    if (axis.endless || (target[i] >= axis.low - 1e-9 && target[i] <= axis.high + 1e-9)) continue;
    const std::string unit = unit_name(axis);
    throw core::InputError(place_ + " axis " + axis.id, fmt::format("{:.6g} {}", target[i] / unit_of(axis), unit),
                           fmt::format("its travel {:.6g} to {:.6g} {}: another place or length of the tool "
                                       "(--radius, --height, --clearance, --angles, --tool-offset, --pose)",
                                       axis.low / unit_of(axis), axis.high / unit_of(axis), unit));
  }
}

void Timeline::begin_stage(const std::string& name, int cycle) {
  Stage stage;
  stage.name = name;
  stage.cycle = cycle;
  stage.start = now_;
  stage.spindle_rpm = spindle_rpm_;
  stage.axes.resize(machine_.axes.size());
  for (Index i = 0; i < pose_.size(); ++i) {
    if (machine_.axes[i].endless) pose_[i] = wrapped(pose_[i]);
    stage.axes[i] = {pose_[i], pose_[i], 0.0, 0.0, pose_[i], pose_[i], false};
  }
  stages_.push_back(std::move(stage));
}

std::string Timeline::target_words(const Pose& target) const {
  std::string words;
  for (Index i = 0; i < target.size(); ++i) {
    if (std::abs(target[i] - pose_[i]) < still) continue;
    words += " " + machine_.axes[i].id + nc_number(target[i] / unit_of(machine_.axes[i]));
  }
  return words;
}

void Timeline::move(const Pose& target, double duration, const std::string& words, const std::string& says) {
  require_in_travel(target);
  Stage& stage = stages_.back();
  for (Index i = 0; i < target.size(); ++i) {
    AxisUse& use = stage.axes[i];
    const double way = std::abs(target[i] - pose_[i]);
    if (way < still) continue;
    use.low = std::min(use.low, target[i]);
    use.high = std::max(use.high, target[i]);
    use.path += way;
    use.moving += duration;
    use.end = target[i];
  }
  stage.blocks.push_back({words, says, now_, duration});
  stage.duration += duration;
  now_ += duration;
  pose_ = target;
}

void Timeline::rapid(const Pose& target, const std::string& says) {
  // An endless axis goes alone, in steps: its absolute position would be ambiguous after a turn.
  for (Index i = 0; i < target.size(); ++i) {
    if (!machine_.axes[i].endless || std::abs(target[i] - pose_[i]) < still) continue;
    Pose turned = pose_;
    turned[i] = target[i];
    const double angle = target[i] - pose_[i];
    move(turned, std::abs(angle) / fastest(i),
         "G91 G00 " + machine_.axes[i].id + nc_number(angle / units::deg) + " G90", says);
  }
  const std::string words = target_words(target);
  if (words.empty()) return;
  double duration = 0.0;
  for (Index i = 0; i < target.size(); ++i) duration = std::max(duration, std::abs(target[i] - pose_[i]) / fastest(i));
  move(target, duration, "G00" + words, says);
}

void Timeline::feed(const Pose& target, double linear, double rotary, const std::string& says) {
  const std::string words = target_words(target);
  if (words.empty()) return;
  double square = 0.0, turned = 0.0, least = 0.0;
  for (Index i = 0; i < target.size(); ++i) {
    const double way = std::abs(target[i] - pose_[i]);
    if (machine_.axes[i].kind == AxisKind::linear) {
      square += way * way;
    } else {
      turned = std::max(turned, way);
    }
    least = std::max(least, way / fastest(i));
  }
  const double straight = std::sqrt(square);
  const bool by_turn = straight < still;
  const double duration = std::max(by_turn ? turned / rotary : straight / linear, least);
  const double speed = by_turn ? turned / duration / units::deg_min : straight / duration / units::mm_min;
  move(target, duration, "G01" + words + " F" + nc_number(speed), says);
}

void Timeline::arc(int axis, const std::vector<Pose>& way, double speed, const std::string& words, double feed_mm_min,
                   const std::string& says) {
  Stage& stage = stages_.back();
  const std::size_t block = stage.blocks.size();
  const double start = now_;
  for (const Pose& at : way) {
    const double duration = std::abs(at[axis] - pose_[axis]) / speed;
    for (Index i = 0; i < at.size(); ++i) {
      const double way_there = std::abs(at[i] - pose_[i]);
      if (way_there > fastest(i) * duration * (1.0 + 1e-9) && way_there > still) {
        throw core::InputError(
            place_ + " axis " + machine_.axes[i].id,
            fmt::format("{:.6g} {}/min on the arc", way_there / duration / unit_of(machine_.axes[i]) * units::minute,
                        unit_name(machine_.axes[i])),
            "its rapid: a lower --feed");
      }
    }
    move(at, duration, "", "");
  }
  stage.blocks.resize(block);
  stage.blocks.push_back({words + " F" + nc_number(feed_mm_min), says, start, now_ - start});
}

void Timeline::turn(int axis, long turns, double speed, const std::string& says) {
  if (turns == 0) return;
  const Axis& of = machine_.axes[axis];
  if (speed > fastest(axis) * (1.0 + 1e-9)) {
    throw core::InputError(place_ + " axis " + of.id, fmt::format("{:.6g} rpm", speed / units::rpm),
                           fmt::format("at most its rapid, {:.6g} rpm", fastest(axis) / units::rpm));
  }
  Stage& stage = stages_.back();
  AxisUse& use = stage.axes[axis];
  const double angle = turn_rad * turns, duration = angle / speed;
  use.turns = true;
  use.path += angle;
  use.moving += duration;
  use.high = use.low + turn_rad;
  stage.blocks.push_back(
      {"G91 G01 " + of.id + nc_number(angle / units::deg) + " F" + nc_number(speed / units::deg_min) + " G90", says,
       now_, duration});
  stage.duration += duration;
  now_ += duration;
}

void Timeline::dwell(double seconds, const std::string& says) {
  if (seconds < 1e-9) return;
  stages_.back().blocks.push_back({"G04 P" + nc_number(seconds), says, now_, seconds});
  stages_.back().duration += seconds;
  now_ += seconds;
}

void Timeline::spindle(double rpm) {
  if (rpm < 0 || (machine_.spindle_max_rpm > 0 && rpm > machine_.spindle_max_rpm)) {
    throw core::InputError(place_ + " spindle", fmt::format("{:.6g} rpm", rpm),
                           fmt::format("0 to {:.6g} rpm", machine_.spindle_max_rpm));
  }
  if (rpm == spindle_rpm_) return;
  spindle_rpm_ = rpm;
  stages_.back().spindle_rpm = rpm;
  stages_.back().blocks.push_back({rpm > 0 ? "S" + nc_number(rpm) + " M03" : "M05", "", now_, 0.0});
}

std::string nc_text(const mesh::Machine& machine, const Timeline& timeline, const std::string& title) {
  std::string axes;
  for (const Axis& axis : machine.axes) axes += (axes.empty() ? "" : ", ") + axis.id + " in " + unit_name(axis);
  std::string text = "%\n(" + title + ")\n(machine " + machine.name + "; positions of the axes: " + axes + ")\n";
  text += "(feeds in mm/min, of a rotary axis alone in deg/min; dwells in s)\nN10 G21 G90 G94\n";
  long number = 10;
  for (const Stage& stage : timeline.stages()) {
    text += fmt::format("({:.3f} s: {})\n", stage.start, stage.name);
    for (const NcBlock& block : stage.blocks) {
      number += 10;
      text += fmt::format("N{} {}{}\n", number, block.words, block.says.empty() ? "" : " (" + block.says + ")");
    }
  }
  return text + fmt::format("N{} M30\n%\n", number + 10);
}

namespace {

/// The tables [[phase.axis]] of a stage. @param stands  positions of the phase before, updated
std::string axes_text(const mesh::Machine& machine, const Stage& stage, Pose& stands) {
  std::string text;
  for (Index i = 0; i < std::ssize(machine.axes); ++i) {
    const Axis& axis = machine.axes[i];
    const AxisUse& use = stage.axes[i];
    const double unit = unit_of(axis);
    const std::string name = unit_name(axis), head = "[[phase.axis]]\nid = \"" + axis.id + "\"\n";
    if (use.path > still) {
      const double duty = std::min(100.0, 100.0 * use.moving / stage.duration);
      const double speed = use.path / stage.duration * 100.0 / duty;
      if (use.turns) {
        text += head + fmt::format("speed_rpm = {:.12g}\nduty_percent = {:.12g}\n", speed / units::rpm, duty);
      } else {
        text +=
            head + fmt::format(
                       "low_{0} = {1:.12g}\nhigh_{0} = {2:.12g}\nfeed_{0}_min = {3:.12g}\nduty_percent = "
                       "{4:.12g}\n",
                       name, use.low / unit, std::min(use.high, use.low + turn_rad * (axis.endless ? 1 : 1e9)) / unit,
                       speed / unit * units::minute, duty);
      }
    } else if (std::abs(use.end - stands[i]) > still) {
      text += head + fmt::format("position_{} = {:.12g}\n", name, use.end / unit);
      stands[i] = use.end;
    }
  }
  return text;
}

}  // namespace

std::string load_text(const mesh::Machine& machine, const Timeline& timeline, const std::string& title,
                      const std::optional<std::pair<double, double>>& air_C, double initial_C) {
  if (air_C && machine.ambient_index("air") < 0)
    throw core::InputError("plan --air", "an air temperature", "a machine with an [[ambient]] of id air");
  const double half = 0.5 * timeline.now();
  const auto air_at = [&](double time) {
    return air_C->first + (air_C->second - air_C->first) * (1.0 - std::abs(time - half) / half);
  };
  std::string text = "# SPDX-License-Identifier: GPL-3.0-or-later\nschema = 1\n";
  text += fmt::format("title = \"{}\"\ninitial_C = {}\ntime_step_s = 60\noutput_s = 300\n", title,
                      air_C ? air_C->first : initial_C);
  const std::vector<Stage>& stages = timeline.stages();
  Pose stands(std::ssize(machine.axes));
  std::string places;
  for (Index i = 0; i < stands.size(); ++i) {
    const Axis& axis = machine.axes[i];
    stands[i] = stages.front().axes[i].begin;
    places += fmt::format("{}{}_{} = {:.12g}", i == 0 ? "" : ", ", axis.id, unit_name(axis), stands[i] / unit_of(axis));
  }
  if (!places.empty()) text += "position = {" + places + "}\n";
  double spindle = 0.0;
  for (const Stage& stage : stages) {
    if (stage.duration < 1e-6) continue;
    text += fmt::format("\n[[phase]]\nname = \"{}\"\nduration_s = {:.12g}\n", stage.name, stage.duration);
    if (stage.spindle_rpm != spindle) text += fmt::format("spindle_rpm = {:.12g}\n", stage.spindle_rpm);
    spindle = stage.spindle_rpm;
    if (air_C) {
      text += fmt::format("air_C = [{:.9g}, {:.9g}]\n", air_at(stage.start), air_at(stage.start + stage.duration));
    }
    text += axes_text(machine, stage, stands);
  }
  return text;
}

}  // namespace thermotwin::metrology
