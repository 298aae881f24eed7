// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/axis_motion.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::nc {

using core::InputError;
namespace units = core::units;

namespace {

std::string place_of(const std::string& file, const MoveState& state) { return fmt::format("{}:{}", file, state.line); }

}  // namespace

AxisMotion::AxisMotion(const mesh::Machine& machine) : machine_(machine) {
  for (const mesh::Axis& axis : machine.axes) letter_.push_back(letter_of(axis));
  if (machine.has_tcp()) {
    int linear = 0;
    for (const mesh::Axis& axis : machine.axes) linear += axis.kind == mesh::AxisKind::linear ? 1 : 0;
    if (linear == 3) tcp_.emplace(machine);
  }
}

int AxisMotion::axis_mask() const {
  int mask = 0;
  for (const int letter : letter_)
    if (letter >= 0) mask |= 1 << letter;
  return mask;
}

Nine AxisMotion::letters_of(const Positions& positions) const {
  Nine values = Nine::Zero();
  for (std::size_t i = 0; i < letter_.size(); ++i)
    if (letter_[i] >= 0) values[letter_[i]] = positions[i];
  return values;
}

Positions AxisMotion::positions_of(const Nine& values) const {
  Positions positions = Positions::Zero(std::ssize(letter_));
  for (std::size_t i = 0; i < letter_.size(); ++i)
    if (letter_[i] >= 0) positions[i] = values[letter_[i]];
  return positions;
}

Positions AxisMotion::positions(const Nine& values, const Move& move) const {
  Positions positions = positions_of(values);
  if (move.state.tcp) tcp_->solve(values.head<3>() - move.tool_offset, move.tool_offset, positions);
  return positions;
}

Nine AxisMotion::values(const Positions& positions, const Move& move, const Nine& nominal) const {
  Nine values = nominal;
  for (std::size_t i = 0; i < letter_.size(); ++i)
    if (letter_[i] >= 0) values[letter_[i]] = positions[i];
  if (move.state.tcp) values.head<3>() = tcp_->point(positions, move.tool_offset) + move.tool_offset;
  return values;
}

Eigen::Vector3d AxisMotion::tip(const Positions& positions, const Eigen::Vector3d& tool_offset) const {
  return tcp_ ? tcp_->point(positions, tool_offset) : letters_of(positions).head<3>() - tool_offset;
}

Nine AxisMotion::values_at(const Move& move, double u) {
  Nine values = move.from + u * (move.to - move.from);
  if (move.kind == MoveKind::arc) {
    const Arc& arc = move.arc;
    const double r = arc.start_radius + (arc.end_radius - arc.start_radius) * u, phi = arc.angle * u;
    const Eigen::Vector3d start = arc.centre + arc.start_radius * arc.first,
                          end = arc.centre +
                                arc.end_radius * (std::cos(arc.angle) * arc.first + std::sin(arc.angle) * arc.second),
                          rise = (move.to.head<3>() - end) - (move.from.head<3>() - start);
    values.head<3>() = arc.centre + r * (std::cos(phi) * arc.first + std::sin(phi) * arc.second) +
                       (move.from.head<3>() - start) + u * rise;
  }
  return values;
}

Element AxisMotion::whole(const Move& move) const {
  Element element = Element::line(positions_of(move.from), positions_of(move.to));
  if (move.kind != MoveKind::arc) return element;
  Nine first = Nine::Zero(), second = Nine::Zero();
  first.head<3>() = move.arc.first;
  second.head<3>() = move.arc.second;
  element.first = positions_of(first);
  element.second = positions_of(second);
  element.r0 = move.arc.start_radius;
  element.r1 = move.arc.end_radius;
  element.angle = move.arc.angle;
  const Positions start = element.base, end = positions_of(move.to);
  element.base = start - element.r0 * element.first;
  element.slope = end - element.base -
                  element.r1 * (std::cos(element.angle) * element.first + std::sin(element.angle) * element.second);
  return element;
}

void AxisMotion::require_axes(const Move& move, const std::string& file) const {
  const int mask = axis_mask();
  for (int i = 0; i < 9; ++i) {
    if ((mask >> i & 1) != 0 || move.from[i] == move.to[i]) continue;
    std::vector<std::string> ids;
    for (const mesh::Axis& axis : machine_.axes) ids.push_back(axis.id);
    throw InputError(place_of(file, move.state),
                     fmt::format("a move of {}, which is no axis of {}", letters[i], machine_.name),
                     "one of: " + core::join(ids));
  }
  if (move.state.tcp && !tcp_)
    throw InputError(place_of(file, move.state), "tool centre point control on " + machine_.name,
                     "a machine with three linear axes and [tcp]");
}

void AxisMotion::require_travel(const Element& element, const std::string& file) const {
  Positions travel = Positions::Zero(element.base.size()), low = element.at(0.0), high = low;
  element.sweep(0.0, 1.0, travel, low, high);
  for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
    const mesh::Axis& axis = machine_.axes[i];
    if (axis.endless) continue;
    const Eigen::Index at = i;
    constexpr double slack = 1e-9;
    const bool below = low[at]<axis.low - slack, above = high[at]> axis.high + slack;
    if (!below && !above) continue;
    const bool linear = axis.kind == mesh::AxisKind::linear;
    const double unit = linear ? units::mm : units::deg;
    throw InputError(
        place_of(file, element.state),
        fmt::format("axis {} at {:.4f} {}", axis.id, (below ? low[at] : high[at]) / unit, linear ? "mm" : "deg"),
        fmt::format("its travel, {:.4f} to {:.4f}", axis.low / unit, axis.high / unit));
  }
}

void AxisMotion::elements(const Move& move, const std::string& file, const std::shared_ptr<const Source>& source,
                          const std::function<void(Element&&)>& take) const {
  require_axes(move, file);
  const bool angular = move.has_only_angles();
  const auto give = [&](Element&& element, double share, bool last) {
    element.angular = angular;
    element.length = move.length * share;
    element.speed = move.speed;
    element.rapid = move.kind == MoveKind::traverse;
    element.path_mode = move.path_mode;
    element.exact_stop = last && (move.path_mode == 1 || move.kind == MoveKind::tap || move.kind == MoveKind::probe);
    element.tolerance = move.tolerance;
    element.state = move.state;
    element.last = last;
    if (last) element.source = source;
    require_travel(element, file);
    take(std::move(element));
  };
  if (!move.state.tcp) {
    give(whole(move), 1.0, true);
    return;
  }
  // Halved until the middle of a line is where the move is.
  constexpr double nearest = 2e-7;  // m
  constexpr int deepest = 14;
  struct Part {
    double u0, u1;
    Positions q0, q1;
    int depth;
  };
  const int parts = move.kind == MoveKind::arc
                        ? std::max(2, static_cast<int>(std::ceil(move.arc.angle / (0.25 * std::numbers::pi))))
                        : 1;
  std::vector<Part> stack;
  for (int k = parts; k > 0; --k) {
    const double end = k, u0 = (end - 1.0) / parts, u1 = end / parts;
    stack.push_back(
        {u0, u1, positions(values_at(move, u0), move), positions(k == parts ? move.to : values_at(move, u1), move), 0});
  }
  while (!stack.empty()) {
    Part part = std::move(stack.back());
    stack.pop_back();
    const double middle = 0.5 * (part.u0 + part.u1);
    Positions q = positions(values_at(move, middle), move);
    double off = 0.0;
    for (std::size_t i = 0; i < machine_.axes.size(); ++i)
      if (machine_.axes[i].kind == mesh::AxisKind::linear) {
        const Eigen::Index at = i;
        off = std::max(off, std::abs(q[at] - 0.5 * (part.q0[at] + part.q1[at])));
      }
    if (off > nearest && part.depth < deepest) {
      stack.push_back({middle, part.u1, q, part.q1, part.depth + 1});
      stack.push_back({part.u0, middle, part.q0, q, part.depth + 1});
      continue;
    }
    give(Element::line(part.q0, part.q1), part.u1 - part.u0, part.u1 == 1.0);
  }
}

}  // namespace thermotwin::nc
