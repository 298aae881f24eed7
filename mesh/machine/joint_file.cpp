// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces of machine.toml, and the joints and scales between bodies.

#include "mesh/machine/joint_file.h"

#include <fmt/format.h>

#include <cmath>

#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/loss_file.h"
#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;
using core::Node;

namespace {

constexpr double usual_angle_deg = 20.001;  ///< 20 with the rounding of a triangle's normal

void require_together(const Node& node, const std::vector<std::string>& keys) {
  for (const std::string& given : keys) {
    for (const std::string& other : keys) {
      if (node.has(given) && !node.has(other))
        throw InputError(node.place(given), "'" + given + "' without '" + other + "'", core::join(keys) + " together");
    }
  }
}

Rule read_rule(const Node& node) {
  Rule rule;
  rule.place = node.place();
  require_together(node, {"plane_point_mm", "plane_normal"});
  require_together(node, {"cylinder_point_mm", "cylinder_axis", "cylinder_radius_mm"});
  require_together(node, {"box_min_mm", "box_max_mm"});
  rule.group = node.text_or("group", "");
  if (node.has("plane_point_mm")) {
    rule.plane_point = point_mm(node, "plane_point_mm");
    rule.plane_normal = unit_vector(node, "plane_normal");
  }
  if (node.has("cylinder_axis")) {
    rule.cylinder_point = point_mm(node, "cylinder_point_mm");
    rule.cylinder_axis = unit_vector(node, "cylinder_axis");
    rule.cylinder_radius = node.number("cylinder_radius_mm") * millimetre;
  }
  if (node.has("box_min_mm")) {
    rule.box_min = point_mm(node, "box_min_mm");
    rule.box_max = point_mm(node, "box_max_mm");
    if (!(rule.box_min->array() <= rule.box_max->array()).all())
      throw InputError(node.place("box_min_mm"), "a corner above box_max_mm", "box_min_mm <= box_max_mm in x, y and z");
  }
  if (node.has("normal")) {
    rule.normal = unit_vector(node, "normal");
    rule.max_angle = (node.has("max_angle_deg") ? node.number("max_angle_deg") : usual_angle_deg) * degree;
  } else {
    refuse(node, "max_angle_deg", "together with normal = [x, y, z]");
  }
  if (node.has("tolerance_mm")) rule.tolerance = node.number("tolerance_mm") * millimetre;
  node.finish();
  if (rule.group.empty() && !rule.plane_point && !rule.cylinder_axis && !rule.box_min && !rule.normal) {
    throw InputError(rule.place, "a rule without a condition",
                     "one or more of: group, plane_point_mm with plane_normal, cylinder_point_mm with "
                     "cylinder_axis and cylinder_radius_mm, box_min_mm with box_max_mm, normal");
  }
  return rule;
}

Eigen::Vector3i read_divide(const Node& node) {
  const Eigen::Vector3d cells = node.vector3("divide");
  for (const double count : cells) {
    if (!(count >= 1.0 && count <= 1000.0) || count != std::floor(count))
      throw InputError(node.place("divide"), fmt::format("{}", count), "three whole numbers from 1 to 1000");
  }
  return cells.cast<int>();
}

}  // namespace

SurfaceSpec read_surface_spec(const Node& node, Draft& draft) {
  SurfaceSpec surface;
  surface.place = node.place();
  surface.id = draft.define(node, "surface");
  surface.body = draft.refer(node, "body", "body");
  if (node.has("rule")) refuse(node, "rules", "either rule or rules");
  if (const auto rule = node.table_if("rule")) surface.any_of.push_back(read_rule(*rule));
  for (const Node& rule : node.tables("rules")) surface.any_of.push_back(read_rule(rule));
  surface.except = node.texts_or_empty("except");
  for (const std::string& id : surface.except) draft.references.push_back({"surface", id, node.place("except")});
  node.finish();
  return surface;
}

JointSpec read_joint(const Node& node, Draft& draft) {
  JointSpec joint;
  joint.id = draft.define(node, "joint");
  joint.kind = node.choice("kind");
  joint.slave = draft.refer(node, "slave", "surface");
  if (joint.kind == "mount") {
    refuse(node, "master", "a mount stands on the ground: ambient = \"foundation\" instead");
    refuse(node, "axis", "a mount does not move");
    joint.ambient = draft.refer(node, "ambient", "ambient");
  } else {
    refuse(node, "ambient", "only a mount has an ambient; other joints have a master");
    joint.master = draft.refer(node, "master", "surface");
    joint.axis = draft.refer_or_empty(node, "axis", "axis");
  }
  joint.conductance = node.uncertain("conductance_W_m2K");
  joint.law = read_contact_law(node, joint.axis);
  joint.stiffness_normal = scaled(node.uncertain("stiffness_normal_N_mm3"), core::units::N_mm3);
  joint.stiffness_tangential = scaled(node.uncertain("stiffness_tangential_N_mm3"), core::units::N_mm3);
  joint.reach = node.number("reach_mm") * millimetre;
  if (node.has("divide")) joint.divide = read_divide(node);
  joint.sectors = node.integer("sectors");
  if (joint.sectors > 0) {
    refuse(node, "divide", "either divide or sectors");
    joint.sector_point = point_mm(node, "sector_point_mm");
    joint.sector_axis = unit_vector(node, "sector_axis");
  }
  node.finish();
  return joint;
}

namespace {

/// The tape measures along its axis.
void require_along_axis(const Node& node, const ScaleSpec& scale, const Machine& machine) {
  const int index = machine.axis_index(scale.axis);
  if (index < 0 || machine.axes[index].kind != AxisKind::linear) return;
  const Eigen::Vector3d& along = machine.axes[index].direction;
  const Eigen::Vector3d tape = scale.end - scale.start;
  if (std::abs(tape.dot(along)) >= 0.99 * tape.norm()) return;
  const double angle = std::acos(std::min(1.0, std::abs(tape.dot(along)) / tape.norm())) / degree;
  const Eigen::Vector3d end = (scale.start + tape.norm() * (tape.dot(along) < 0.0 ? -1.0 : 1.0) * along) / millimetre;
  throw InputError(
      node.place("end_mm"), fmt::format("a tape from start_mm that is {:.3g} deg off axis {}", angle, scale.axis),
      fmt::format("at most 8 deg off it: [{:g}, {:g}, {:g}] would be along it", end.x(), end.y(), end.z()));
}

}  // namespace

ScaleSpec read_scale(const Node& node, Draft& draft) {
  ScaleSpec scale;
  scale.axis = draft.refer(node, "axis", "axis");
  draft.places["scale " + std::to_string(draft.machine.scales.size())] = node.place();
  scale.carrier = draft.refer(node, "carrier", "body");
  scale.head_body = draft.refer(node, "head_body", "body");
  scale.start = point_mm(node, "start_mm");
  scale.end = point_mm(node, "end_mm");
  scale.fixed_at = point_mm(node, "fixed_at_mm");
  scale.head = point_mm(node, "head_mm");
  scale.expansion = node.uncertain("expansion_1_K");
  node.finish();
  if ((scale.end - scale.start).norm() < 1e-6)
    throw InputError(node.place("end_mm"), "the same point as start_mm", "the two ends of the tape");
  require_along_axis(node, scale, draft.machine);
  return scale;
}

}  // namespace thermotwin::mesh::reader
