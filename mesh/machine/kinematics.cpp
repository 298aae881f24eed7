// SPDX-License-Identifier: GPL-3.0-or-later
// Poses: where the axes stand, and what that does to the bodies.

#include "mesh/machine/kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::mesh {

using core::InputError;

namespace {

/// Length of the unit in which people write positions of this axis: mm or deg.
double unit(const Axis& axis) { return axis.kind == AxisKind::linear ? core::units::mm : core::units::deg; }

double wrapped(double angle) {
  const double turn = 2.0 * std::numbers::pi;
  const double rest = std::fmod(angle, turn);
  return rest < 0.0 ? rest + turn : rest;
}

}  // namespace

Eigen::Isometry3d body_transform(const Machine& machine, int body, const Pose& pose) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  // All frames coincide at home, so each axis acts in the home coordinates of what carries it.
  while (body >= 0) {
    const BodySpec& spec = machine.bodies[body];
    if (const int a = spec.axis.empty() ? -1 : machine.axis_index(spec.axis); a >= 0) {
      const Axis& axis = machine.axes[a];
      Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
      if (axis.kind == AxisKind::linear)
        motion.translate(pose[a] * axis.direction);
      else
        motion.translate(axis.origin).rotate(Eigen::AngleAxisd(pose[a], axis.direction)).translate(-axis.origin);
      result = motion * result;
    }
    body = spec.parent.empty() ? -1 : machine.body_index(spec.parent);
  }
  return result;
}

Pose home_pose(const Machine& machine) {
  Pose pose(std::ssize(machine.axes));
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    pose[i] = std::clamp(0.0, machine.axes[i].low, machine.axes[i].high);
  return pose;
}

std::vector<Pose> workspace_poses(const Machine& machine) {
  const Workspace& workspace = machine.workspace;
  std::vector<Pose> poses = {home_pose(machine)};
  for (std::size_t i = 0; i < workspace.axes.size(); ++i) {
    const int axis = machine.axis_index(workspace.axes[i]);
    std::vector<Pose> finer;
    for (const Pose& pose : poses) {
      for (const double position : workspace.positions[i]) {
        finer.push_back(pose);
        finer.back()[axis] = position;
      }
    }
    poses = std::move(finer);
  }
  return poses;
}

Pose parse_pose(const Machine& machine, const std::string& text, const std::string& place) {
  Pose pose = home_pose(machine);
  std::vector<std::string> known, seen;
  for (const Axis& axis : machine.axes) known.push_back(axis.id);
  if (core::trimmed(text).empty()) return pose;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t comma = std::min(text.find(',', start), text.size());
    const std::string_view part = core::trimmed(std::string_view(text).substr(start, comma - start));
    start = comma + 1;
    const std::size_t equals = part.find('=');
    const std::string name(core::trimmed(part.substr(0, equals)));
    const int index = machine.axis_index(name);
    if (equals == std::string_view::npos || index < 0) {
      throw InputError(place, "'" + std::string(part) + "'",
                       known.empty() ? "an empty pose: the machine has no axes"
                                     : "axis=position in mm or deg, separated by commas; axes: " + core::join(known));
    }
    if (std::find(seen.begin(), seen.end(), name) != seen.end())
      throw InputError(place, "axis " + name + " twice", "each axis once");
    seen.push_back(name);
    std::string_view number = core::trimmed(part.substr(equals + 1));
    if (number.starts_with('+')) number.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(value)) {
      throw InputError(place, "'" + std::string(part) + "'",
                       "a number in " + std::string(machine.axes[index].kind == AxisKind::linear ? "mm" : "deg"));
    }
    const Axis& axis = machine.axes[index];
    double position = value * unit(axis);
    if (axis.endless) {
      position = wrapped(position);
    } else if (position < axis.low - 1e-9 || position > axis.high + 1e-9) {
      throw InputError(
          place, "'" + std::string(part) + "'",
          fmt::format("the travel of axis {}: {:.6g} .. {:.6g}", name, axis.low / unit(axis), axis.high / unit(axis)));
    }
    pose[index] = position;
  }
  return pose;
}

std::string format_pose(const Machine& machine, const Pose& pose) {
  const Eigen::VectorXd values = pose_values(machine, pose);
  std::vector<std::string> words;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const double value = values[i];
    words.push_back(fmt::format("{}={:.7g}", machine.axes[i].id, std::abs(value) < 1e-9 ? 0.0 : value));
  }
  return core::join(words, ",");
}

std::vector<std::string> pose_columns(const Machine& machine) {
  std::vector<std::string> names;
  for (const Axis& axis : machine.axes) names.push_back(axis.id + (axis.kind == AxisKind::linear ? "_mm" : "_deg"));
  return names;
}

Eigen::VectorXd pose_values(const Machine& machine, const Pose& pose) {
  Eigen::VectorXd values = pose;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) values[i] /= unit(machine.axes[i]);
  return values;
}

}  // namespace thermotwin::mesh
