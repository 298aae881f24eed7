// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/test_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/plan/sphere.h"
#include "solver/elastic/outputs.h"

namespace thermotwin::metrology {

namespace units = core::units;
using core::InputError;
using mesh::Axis;
using mesh::AxisKind;
using mesh::Machine;
using mesh::Pose;

namespace {

/// Rotary axes that carry the table, from the table outwards.
std::vector<int> table_axes(const Machine& machine) {
  std::vector<int> axes;
  for (int body = machine.body_index(machine.tcp.table_body); body >= 0;
       body = machine.body_index(machine.bodies[body].parent)) {
    const int axis = machine.axis_index(machine.bodies[body].axis);
    if (axis >= 0 && machine.axes[axis].kind == AxisKind::rotary) axes.push_back(axis);
  }
  return axes;
}

int tested_axis(const Machine& machine, const PlanOptions& options, const std::string& place) {
  if (options.kind == TestKind::etve || options.kind == TestKind::spindle ||
      options.kind == TestKind::volumetric_grid) {
    return -1;
  }
  const bool linear = options.kind == TestKind::linear_axis;
  int axis = -1;
  if (!options.axis.empty()) {
    axis = axis_named(machine, options.axis, place + " --axis");
  } else if (!linear) {
    const std::vector<int> carrying = table_axes(machine);
    if (!carrying.empty()) axis = carrying.front();
  } else {
    for (int i = 0; i < std::ssize(machine.axes) && axis < 0; ++i)
      if (machine.axes[i].kind == AxisKind::linear) axis = i;
  }
  if (axis < 0 || (machine.axes[axis].kind == AxisKind::linear) != linear) {
    throw InputError(place + " --axis", options.axis.empty() ? "no axis" : "'" + options.axis + "'",
                     linear ? "a linear axis" : "a rotary axis");
  }
  const std::vector<int> carrying = table_axes(machine);
  if (!linear && std::find(carrying.begin(), carrying.end(), axis) == carrying.end()) {
    throw InputError(place + " --axis", "'" + machine.axes[axis].id + "', which carries the tool",
                     "a rotary axis that carries the table: the sphere stands on it");
  }
  return axis;
}

std::vector<double> angles_of(const Axis& axis, const PlanOptions& options, const std::string& place) {
  std::vector<double> chosen;
  for (const double angle : options.angles_deg) chosen.push_back(angle * units::deg);
  const bool arc = options.kind == TestKind::rtest_continuous;
  if (arc && !chosen.empty() && chosen.size() != 2)
    throw InputError(place + " --angles", fmt::format("{} angles", chosen.size()), "both ends of the arc");
  if (!chosen.empty()) return chosen;
  constexpr double quarter = 0.5 * std::numbers::pi;
  if (arc) return axis.endless ? std::vector<double>{0.0, 4 * quarter} : std::vector<double>{axis.low, axis.high};
  if (options.kind == TestKind::rotary_axis)
    return axis.endless ? std::vector<double>{0.0, 2 * quarter} : std::vector<double>{axis.low, axis.high};
  if (axis.endless) return {0.0, quarter, 2 * quarter, 3 * quarter};
  for (int i = 0; i < 5; ++i) chosen.push_back(axis.low + i / 4.0 * (axis.high - axis.low));
  return chosen;
}

/// Positions of the axis that carries the tested one; of other tests none.
std::vector<double> tilts_of(const Axis& tilting, const PlanOptions& options) {
  std::vector<double> tilts;
  for (const double tilt : options.tilts_deg) tilts.push_back(tilt * units::deg);
  if (!tilts.empty()) return tilts;
  for (const double tilt : {0.0, 30.0, 60.0, 90.0}) {
    const double angle = tilt * units::deg;
    if (tilting.endless || (angle >= tilting.low && angle <= tilting.high)) tilts.push_back(angle);
  }
  return tilts;
}

/// The positions of the linear axes in the workspace, the first axis slowest, and the first of them again.
std::vector<Pose> grid_poses(const Machine& machine, const Pose& rest, const std::string& place) {
  std::vector<Pose> poses{rest};
  for (std::size_t a = 0; a < machine.workspace.axes.size(); ++a) {
    const int axis = machine.axis_index(machine.workspace.axes[a]);
    if (axis < 0 || machine.axes[axis].kind != AxisKind::linear) continue;
    std::vector<Pose> finer;
    for (const Pose& pose : poses) {
      for (const double position : machine.workspace.positions[a]) {
        finer.push_back(pose);
        finer.back()[axis] = position;
      }
    }
    poses = std::move(finer);
  }
  if (poses.size() < 2) {
    throw InputError(place, "a machine without positions of linear axes in its [workspace]",
                     "at least two positions of a linear axis");
  }
  poses.push_back(poses.front());
  return poses;
}

}  // namespace

int axis_named(const Machine& machine, const std::string& id, const std::string& place) {
  const int index = machine.axis_index(id);
  if (index >= 0) return index;
  std::vector<std::string> ids;
  for (const Axis& axis : machine.axes) ids.push_back(axis.id);
  throw InputError(place, "'" + id + "'",
                   "axes of the machine: " + core::join(ids) + " (nearest: " + core::nearest(id, ids) + ")");
}

TestPlaces test_places(const Machine& machine, const PlanOptions& options, const Pose& rest, const std::string& place) {
  TestPlaces result;
  result.axis = tested_axis(machine, options, place);
  const TestKind kind = options.kind;
  if (kind == TestKind::volumetric_grid) {
    result.poses = grid_poses(machine, rest, place);
    return result;
  }
  if (result.axis < 0) {
    result.poses = {rest};
    return result;
  }
  if (kind == TestKind::linear_axis) {
    const auto [low, high] = load_range(machine, result.axis, options);
    for (const double position : {low, high}) {
      result.poses.push_back(rest);
      result.poses.back()[result.axis] = position;
    }
    return result;
  }
  result.on_sphere = true;
  std::vector<Eigen::Vector3d> spheres;
  for (const double azimuth : options.azimuths_deg) {
    spheres.push_back(
        sphere_on_table(machine, options.radius_mm * units::mm, azimuth * units::deg, options.height_mm * units::mm));
  }
  int tilting = -1;
  std::vector<double> tilts{0.0};
  if (kind == TestKind::rtest_grid) {
    const std::vector<int> carrying = table_axes(machine);
    const auto at = std::find(carrying.begin(), carrying.end(), result.axis) + 1;
    if (at == carrying.end()) {
      throw InputError(place + " --axis", "'" + machine.axes[result.axis].id + "'",
                       "an axis of the table that another rotary axis carries");
    }
    tilting = *at;
    tilts = tilts_of(machine.axes[tilting], options);
  }
  for (const double tilt : tilts) {
    for (const double angle : angles_of(machine.axes[result.axis], options, place)) {
      Pose rotary = rest;
      if (tilting >= 0) rotary[tilting] = tilt;
      rotary[result.axis] = angle;
      for (const Eigen::Vector3d& sphere : spheres) {
        result.poses.push_back(pose_on_sphere(machine, rotary, sphere, place));
        result.spheres.push_back(sphere);
      }
    }
  }
  if (kind != TestKind::rotary_axis && kind != TestKind::rtest_continuous) {
    result.poses.push_back(result.poses.front());
    result.spheres.push_back(spheres.front());
  }
  return result;
}

}  // namespace thermotwin::metrology
