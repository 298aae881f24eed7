// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/structure_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "core/progress.h"
#include "core/text.h"
#include "core/toml_place.h"
#include "mesh/machine/kinematic_chain.h"
#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

using core::InputError;

namespace {

constexpr double largest_heat = 30e3;  ///< W of one source; spindles of 100 kW lose 10 to 20 kW
constexpr double off_centre = 0.5;     ///< of the table's radius

using Ids = std::vector<std::string>;

/// Axes from the ground to the body.
Ids axes_to(const Machine& machine, const std::string& body) {
  Ids axes;
  for (int at = machine.body_index(body); at >= 0; at = machine.body_index(machine.bodies[at].parent))
    if (const std::string& axis = machine.bodies[at].axis; !axis.empty()) axes.insert(axes.begin(), axis);
  return axes;
}

bool holds(const Ids& ids, const std::string& id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); }

/// The axes that both lists hold, in the order of the first.
Ids common(const Ids& of, const Ids& other) {
  Ids both;
  std::copy_if(of.begin(), of.end(), std::back_inserter(both), [&](const std::string& id) { return holds(other, id); });
  return both;
}

Ids ids_of(const std::vector<ChainAxis>& branch) {
  Ids ids;
  for (const ChainAxis& axis : branch) ids.push_back(axis.id);
  return ids;
}

/// The chain of the bodies in the notation of ISO 10791-1. @param table, tool  from the ground
std::string written(const Ids& table, const Ids& tool) {
  std::string text = "[w";
  for (auto axis = table.rbegin(); axis != table.rend(); ++axis) text += " " + *axis + "'";
  text += " b";
  for (const std::string& axis : tool) text += " " + axis;
  return text + " t]";
}

std::string brief(const Ids& ids) { return ids.empty() ? "no axis" : core::join(ids, ", "); }

void check_joint_sides(const Draft& draft) {
  const Machine& machine = draft.machine;
  for (const JointSpec& joint : machine.joints) {
    if (joint.axis.empty() || joint.master.empty()) continue;
    const std::string &slave = machine.surfaces[machine.surface_index(joint.slave)].body,
                      &master = machine.surfaces[machine.surface_index(joint.master)].body;
    if (holds(axes_to(machine, slave), joint.axis) || !holds(axes_to(machine, master), joint.axis)) continue;
    core::warn(fmt::format(
        "{0}: axis {1} moves '{2}', the body of master, and not '{3}', the body of slave; allowed: slave = a surface "
        "of what the axis moves, master = one of what it moves on. Exchange slave and master",
        draft.place("joint", joint.id), joint.axis, master, slave));
  }
}

void check_table_point(const Draft& draft) {
  const Machine& machine = draft.machine;
  if (!machine.has_tcp()) return;
  const BodySpec& table = machine.bodies[machine.body_index(machine.tcp.table_body)];
  const int index = table.axis.empty() ? -1 : machine.axis_index(table.axis);
  if (index < 0 || machine.axes[index].kind != AxisKind::rotary || !(machine.tcp.table_radius > 0.0)) return;
  const Axis& axis = machine.axes[index];
  const Eigen::Vector3d from = machine.tcp.table_point - axis.origin;
  const double distance = (from - axis.direction * axis.direction.dot(from)).norm(),
               allowed = off_centre * machine.tcp.table_radius;
  if (distance <= allowed) return;
  core::warn(fmt::format(
      "{}: [{:.6g}, {:.6g}, {:.6g}] is {:.4g} mm from axis {} of the table; allowed: the centre of the "
      "table top, at most {:.4g} mm (half of table_radius_mm) from the axis through origin_mm = [{:.6g}, {:.6g}, "
      "{:.6g}]",
      core::toml_place(machine.text, machine.path.string(), "tcp", "table_point_mm"), 1e3 * machine.tcp.table_point[0],
      1e3 * machine.tcp.table_point[1], 1e3 * machine.tcp.table_point[2], 1e3 * distance, axis.id, 1e3 * allowed,
      1e3 * axis.origin[0], 1e3 * axis.origin[1], 1e3 * axis.origin[2]));
}

void check_powers(const Draft& draft) {
  for (const SourceSpec& source : draft.machine.sources) {
    const auto check = [&](const std::string& key, double power) {
      if (std::abs(power) <= largest_heat) return;
      core::warn(
          fmt::format("{} {}: {:.6g} W of heat; allowed without this warning: up to {:.0f} W. A source states "
                      "the heat that stays in the machine, in W",
                      draft.place("source", source.id), key, power, largest_heat));
    };
    check("standstill_W", source.scale.value * source.standstill);
    for (std::size_t i = 0; i < source.laws.size(); ++i) {
      const PowerLaw& law = source.laws[i];
      if (law.power.empty()) continue;
      check(fmt::format("law[{}].power_W", i + 1),
            source.scale.value * *std::max_element(law.power.begin(), law.power.end(),
                                                   [](double a, double b) { return std::abs(a) < std::abs(b); }));
    }
  }
}

}  // namespace

void check_chain(const Draft& draft, const std::string& place) {
  const Machine& machine = draft.machine;
  const KinematicChain chain = KinematicChain::parse(machine.kinematic_chain, place);
  for (const Axis& axis : machine.axes)
    if (chain.find(axis.id) == nullptr) core::warn(place + ": the chain has no axis '" + axis.id + "'");
  for (const std::string& id : chain.ids()) {
    const int index = machine.axis_index(id);
    if (index < 0) {
      core::warn(place + ": axis '" + id + "' of the chain is no [[axis]] of the machine");
      continue;
    }
    const bool rotary = machine.axes[index].kind == AxisKind::rotary;
    if (rotary == chain.find(id)->rotary) continue;
    throw InputError(place, fmt::format("axis '{}', which is {} by its letter", id, rotary ? "linear" : "rotary"),
                     fmt::format("an axis of kind {}, as [[axis]] {} states", rotary ? "rotary" : "linear", id));
  }
  if (!machine.has_tcp()) return;
  Ids table = axes_to(machine, machine.tcp.table_body), tool = axes_to(machine, machine.tcp.tool_body);
  // What carries both moves neither against the other.
  while (!table.empty() && !tool.empty() && table.front() == tool.front()) {
    table.erase(table.begin());
    tool.erase(tool.begin());
  }
  const std::string allowed = "the chain of the bodies' parents and axes: " + written(table, tool);
  const auto require_branch = [&](const std::vector<ChainAxis>& branch, const Ids& bodies, const Ids& other,
                                  const std::string& carried, const std::string& carried_by_bodies) {
    const Ids stated = ids_of(branch);
    for (const std::string& id : stated) {
      if (!holds(other, id)) continue;
      throw InputError(
          place,
          fmt::format("axis '{}' carries the {}; by the bodies it carries the {}", id, carried, carried_by_bodies),
          allowed);
    }
    const Ids by_chain = common(stated, bodies), by_bodies = common(bodies, stated);
    if (by_chain == by_bodies) return;
    throw InputError(
        place, fmt::format("from the bed to the {}: {}; by the bodies: {}", carried, brief(by_chain), brief(by_bodies)),
        allowed);
  };
  require_branch(chain.table, table, tool, "workpiece", "tool");
  require_branch(chain.tool, tool, table, "tool", "workpiece");
}

void check_structure(const Draft& draft) {
  check_joint_sides(draft);
  check_table_point(draft);
  check_powers(draft);
}

}  // namespace thermotwin::mesh::reader
