// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/displaced_move.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

constexpr double full_turn = 2.0 * std::numbers::pi;

}  // namespace

bool whole_turns(const Arc& arc) {
  const double turns = arc.angle / (2.0 * std::numbers::pi);
  return std::abs(turns - std::round(turns)) < 1e-9;
}

Eigen::Vector3d centre_of(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& wanted,
                          const Eigen::Vector3d& normal) {
  const auto flat = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - v.dot(normal) * normal; };
  const Eigen::Vector3d chord = flat(end - start);
  Eigen::Vector3d centre = wanted;
  if (chord.norm() > 1e-9) {
    const Eigen::Vector3d along = chord.normalized(), middle = start + 0.5 * chord;
    centre -= along.dot(wanted - middle) * along;
  }
  return centre;
}

std::vector<double> DisplacedMove::bends() const {
  std::vector<double> shares = predicted_.field->bends(predicted_.start, predicted_.time);
  for (double& share : shares) share = predicted_.share_at(share);
  return shares;
}

Eigen::Vector3d DisplacedMove::displacement(double u) const {
  const bool cuts = move().kind == MoveKind::traverse || u == 0.0;
  if (u == 1.0) return displacement(move().to, predicted_.end, predicted_.offset_um * units::um, cuts);
  const Nine nominal = AxisMotion::values_at(move(), u);
  Positions positions = motion_.positions(nominal, move());
  const Eigen::VectorXd offsets = predicted_.field->offsets(positions, predicted_.time_at(u));
  return displacement(nominal, std::move(positions), offsets, cuts);
}

Eigen::Vector3d DisplacedMove::wanted(const MoveSample& sample) const {
  const Nine nominal = motion_.values(sample.positions, move(), move().to);
  return nominal.head<3>() + displacement(nominal, sample.positions, sample.offset_um * units::um, false);
}

Eigen::Vector3d DisplacedMove::displacement(const Nine& nominal, Positions positions, const Eigen::VectorXd& offsets,
                                            bool cuts) const {
  const std::vector<std::string>& axes = predicted_.field->axes();
  const mesh::Machine& machine = motion_.machine();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const int axis = machine.axis_index(axes[i]);
    const double offset = offsets[i];
    if (std::abs(offset) > options_.largest_offset)
      throw core::InputError(place_, fmt::format("an offset of {:.1f} um of axis {}", offset / units::um, axes[i]),
                             fmt::format("at most {:.1f} um", options_.largest_offset / units::um));
    positions[axis] += offset;
    const mesh::Axis& limits = machine.axes[axis];
    if (const double within = std::clamp(positions[axis], limits.low, limits.high); cuts) {
      cut_ = cut_ || std::abs(within - positions[axis]) > 1e-9;
      positions[axis] = within;
    } else if (positions[axis] < limits.low - 1e-9 || positions[axis] > limits.high + 1e-9)
      throw core::InputError(
          place_, fmt::format("axis {} at {:.4f} mm with its offset", axes[i], positions[axis] / units::mm),
          fmt::format("its travel, {:.4f} to {:.4f}", limits.low / units::mm, limits.high / units::mm));
  }
  return (motion_.values(positions, move(), nominal) - nominal).head<3>();
}

struct DisplacedMove::Follower {
  bool arc = false;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ(), centre = Eigen::Vector3d::Zero(), start = centre, end = centre;
  double sweep = 0;  ///< rad

  /// @param part  of the span  @param nominal  point of the program there  @return its displacement
  Eigen::Vector3d displacement(const Span& span, double part, const Eigen::Vector3d& nominal) const {
    if (!arc) return span.d0 + part * (span.d1 - span.d0);
    const Eigen::Vector3d radius = (start - centre) - normal.dot(start - centre) * normal;
    const double rise = normal.dot(start - centre) + part * normal.dot(end - start);
    return centre + Eigen::AngleAxisd(sweep * part, normal) * radius + rise * normal - nominal;
  }
};

DisplacedMove::Follower DisplacedMove::follower(const Span& span) const {
  Follower follower;
  const Arc& arc = move().arc;
  follower.arc = move().kind == MoveKind::arc;
  if (!follower.arc) return follower;
  const auto point = [&](double u) -> Eigen::Vector3d { return AxisMotion::values_at(move(), u).head<3>(); };
  auto& [is_arc, normal, centre, start, end, sweep] = follower;
  normal = arc.first.cross(arc.second);
  start = point(span.u0) + span.d0;
  end = point(span.u1) + span.d1;
  sweep = arc.angle * (span.u1 - span.u0);
  const bool closed = whole_turns(arc) && span.u1 - span.u0 == 1.0;
  centre = closed ? Eigen::Vector3d(arc.centre + span.d0)
                  : centre_of(start, end, arc.centre + 0.5 * (span.d0 + span.d1), normal);
  if (closed) return follower;
  // The turn between the displaced ends is near that of the arc itself.
  const auto flat = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return v - v.dot(follower.normal) * follower.normal;
  };
  const Eigen::Vector3d a = flat(start - centre), b = flat(end - centre);
  double turn = std::atan2(normal.dot(a.cross(b)), a.dot(b));
  turn += 2.0 * std::numbers::pi * std::round((sweep - turn) / (2.0 * std::numbers::pi));
  sweep = turn;
  return follower;
}

/// The ends of an arc of about whole turns are so near that a displacement may change their order.
bool DisplacedMove::nearly_closed() const {
  const Arc& arc = move().arc;
  if (move().kind != MoveKind::arc || whole_turns(arc) || arc.angle < 0.75 * full_turn) return false;
  const double turns = arc.angle / full_turn, gap = std::abs(turns - std::round(turns)) * full_turn;
  return gap * arc.end_radius < 4.0 * options_.largest_offset;
}

void DisplacedMove::split(const Span& span, int depth, std::vector<double>& ends) const {
  constexpr int deepest = 10;
  const Follower follower = this->follower(span);
  bool bends = depth == 0 && nearly_closed();
  const double turns = move().kind == MoveKind::arc ? move().arc.angle * (span.u1 - span.u0) / full_turn : 0.0;
  std::vector<double> parts = {0.5, 0.25, 0.75};
  for (int k = 1; turns > 1.0 + 1e-9 && k < 8.0 * turns; ++k) parts.push_back(k / (8.0 * turns));
  const bool is_long = predicted_.duration() > 1.0;
  if (is_long && turns > 0.0) parts.push_back(1.0);  // a circle ends where it began
  for (const double bend : bends_)
    if (bend > span.u0 && bend < span.u1) parts.push_back((bend - span.u0) / (span.u1 - span.u0));
  for (const double part : parts) {
    const double u = span.share(part);
    const Eigen::Vector3d wanted = displacement(u);
    const double off = (follower.displacement(span, part, AxisMotion::values_at(move(), u).head<3>()) - wanted).norm();
    bends = bends || off > options_.tolerance;
    // Far within the tolerance in the middle: the quarters are as well.
    if (part == 0.5 && turns <= 1.0 + 1e-9 && !is_long && off < options_.tolerance / 8.0) break;
    if (bends) break;
  }
  if (bends && depth < deepest) {
    // Parts of an arc are at most two thirds of a turn, so that no displacement changes their number of turns.
    const long count = std::max(2L, std::lround(std::ceil(1.5 * turns - 1e-9)));
    Span part = span;
    for (int k = 1; k <= count; ++k) {
      part.u1 = k == count ? span.u1 : span.share(1.0 * k / count);
      part.d1 = k == count ? span.d1 : displacement(part.u1);
      split(part, depth + 1, ends);
      part.u0 = part.u1;
      part.d0 = part.d1;
    }
    return;
  }
  ends.push_back(span.u1);
}

std::vector<double> DisplacedMove::pieces(const Eigen::Vector3d& at_start, const Eigen::Vector3d& at_end) const {
  std::vector<double> ends;
  split({0.0, 1.0, at_start, at_end}, 0, ends);
  return ends;
}

}  // namespace thermotwin::nc
