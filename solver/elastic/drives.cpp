// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/drives.h"

#include <algorithm>

namespace thermotwin::solver {
namespace {

/// Along its axis: a guide is free there.
bool holds(const mesh::Machine& machine, const mesh::JointSpec& joint) {
  const auto elastic = [&](const std::string& surface) {
    return machine.bodies[machine.body_index(machine.surfaces[machine.surface_index(surface)].body)].elastic;
  };
  return joint.kind != "guide" && (joint.stiffness_normal.value > 0.0 || joint.stiffness_tangential.value > 0.0) &&
         elastic(joint.slave) && (joint.master.empty() || elastic(joint.master));
}

}  // namespace

std::vector<UnheldAxis> unheld_axes(const mesh::Machine& machine) {
  std::vector<UnheldAxis> unheld;
  for (const mesh::Axis& axis : machine.axes) {
    const auto moved = std::find_if(machine.bodies.begin(), machine.bodies.end(),
                                    [&](const mesh::BodySpec& body) { return body.elastic && body.axis == axis.id; });
    if (axis.kind != mesh::AxisKind::linear || moved == machine.bodies.end()) continue;
    const auto of_axis = [&](const auto& item) { return item.axis == axis.id; };
    const bool has_position = axis.feedback == "screw"
                                  ? std::any_of(machine.screws.begin(), machine.screws.end(), of_axis)
                                  : std::any_of(machine.scales.begin(), machine.scales.end(), of_axis);
    const bool has_joint = std::any_of(machine.joints.begin(), machine.joints.end(), [&](const mesh::JointSpec& joint) {
      return joint.axis == axis.id && holds(machine, joint);
    });
    if (!has_position && !has_joint) unheld.push_back({axis.id, moved->id});
  }
  return unheld;
}

}  // namespace thermotwin::solver
