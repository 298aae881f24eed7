// SPDX-License-Identifier: GPL-3.0-or-later
// Screws and the feedback of linear axes from machine.toml.

#include "mesh/machine/screw_file.h"

#include <algorithm>
#include <cmath>

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;
using core::Node;

namespace {

ScrewSpec read_screw(const Node& node, Draft& draft) {
  ScrewSpec screw;
  draft.places["screw " + std::to_string(draft.machine.screws.size())] = node.place();
  screw.axis = draft.refer(node, "axis", "axis");
  screw.body = draft.refer(node, "body", "body");
  screw.nut_body = draft.refer(node, "nut_body", "body");
  if (const int body = draft.machine.body_index(screw.body); body >= 0)
    screw.carrier = draft.machine.bodies[body].parent;
  screw.bearing = point_mm(node, "fixed_bearing_mm");
  screw.nut = point_mm(node, "nut_mm");
  screw.expansion = node.uncertain("expansion_1_K");
  const std::string ends = node.choice("bearings");
  if (ends == "fixed_fixed") {
    screw.far_bearing = point_mm(node, "far_bearing_mm");
    screw.pretension = node.number("pretension_N");
    screw.bearing_stiffness = node.number("bearing_stiffness_N_um") * 1e6;
  } else {
    for (const char* key : {"far_bearing_mm", "pretension_N", "bearing_stiffness_N_um"})
      refuse(node, key, "bearings = \"fixed_fixed\": else the screw's other end is free along it");
  }
  node.finish();
  if (const int index = draft.machine.axis_index(screw.axis); index >= 0 && screw.far_bearing) {
    const Eigen::Vector3d& along = draft.machine.axes[index].direction;
    const Eigen::Vector3d between = *screw.far_bearing - screw.bearing;
    if (!(std::abs(between.dot(along)) > 0.99 * between.norm()) || between.norm() < 1e-6) {
      throw InputError(node.place("far_bearing_mm"), "a point that is not along the axis from fixed_bearing_mm",
                       "the two bearings on one line along the axis");
    }
  }
  return screw;
}

}  // namespace

void read_screws(const Node& root, Draft& draft) {
  Machine& machine = draft.machine;
  for (const Node& node : root.tables("screw")) machine.screws.push_back(read_screw(node, draft));
  for (Axis& axis : machine.axes) {
    const auto of_axis = [&](const auto& item) { return item.axis == axis.id; };
    const bool scale = std::any_of(machine.scales.begin(), machine.scales.end(), of_axis);
    const bool screw = std::any_of(machine.screws.begin(), machine.screws.end(), of_axis);
    if (axis.kind != AxisKind::linear) continue;
    if (axis.feedback.empty()) axis.feedback = scale ? "scale" : screw ? "screw" : "";
    if ((axis.feedback == "scale" && !scale) || (axis.feedback == "screw" && !screw)) {
      throw InputError(draft.place("axis", axis.id) + " feedback",
                       "\"" + axis.feedback + "\" without a [[" + axis.feedback + "]] of the axis",
                       "a [[" + axis.feedback + "]] with axis = \"" + axis.id + "\"");
    }
  }
}

}  // namespace thermotwin::mesh::reader
