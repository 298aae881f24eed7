// SPDX-License-Identifier: GPL-3.0-or-later
// A machine from machine.toml: its bodies, axes, sensors, TCP and workspace here, the rest in the files
// that reader.h is shared by.

#include "mesh/machine/file.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/file.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/machine/check.h"
#include "mesh/machine/joint_file.h"
#include "mesh/machine/machine_keys.h"
#include "mesh/machine/material_file.h"
#include "mesh/machine/physics_file.h"
#include "mesh/machine/reader.h"
#include "mesh/machine/screw_file.h"
#include "mesh/machine/structure_check.h"

namespace thermotwin::mesh {

using core::InputError;
using core::Node;
using core::Range;

namespace reader {

namespace {

std::filesystem::path read_cad_path(const Node& node, const Draft& draft, bool must_exist) {
  static const std::vector<std::string> known = {".step", ".stp", ".iges", ".igs", ".brep", ".stl", ".obj",
                                                 ".ply",  ".3mf", ".gltf", ".glb", ".msh",  ".vtu", ".inp"};
  const std::string written = node.text("cad");
  const std::filesystem::path folder = std::filesystem::absolute(draft.machine.path).parent_path();
  const std::filesystem::path path = (folder / written).lexically_normal();
  if (std::find(known.begin(), known.end(), core::lower(path.extension().string())) == known.end())
    throw InputError(node.place("cad"), "'" + written + "'", "a file of type " + core::join(known));
  std::error_code ignored;
  if (must_exist && !std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(node.place("cad"), "no such file: '" + path.string() + "'",
                     "the path of a file, relative to the folder of machine.toml");
  }
  return path;
}

BodySpec read_body(const Node& node, Draft& draft, bool files_must_exist) {
  BodySpec body;
  body.id = draft.define(node, "body");
  body.material = draft.refer(node, "material", "material");
  body.cad = read_cad_path(node, draft, files_must_exist);
  const std::string unit = node.choice("unit");
  body.unit_m = unit == "mm" ? 1e-3 : unit == "m" ? 1.0 : 0.0254;
  body.element_size = node.number("element_size_mm") * millimetre;
  body.elements_per_turn = node.integer("elements_per_turn");
  body.parent = draft.refer_or_empty(node, "parent", "body");
  body.axis = draft.refer_or_empty(node, "axis", "axis");
  body.elastic = node.boolean("elastic");
  body.pieces = node.integer("pieces");
  body.max_elements = node.number("max_elements");
  body.lattice = node.choice("mesher") == "lattice";
  node.finish();
  return body;
}

Axis read_axis(const Node& node, Draft& draft) {
  Axis axis;
  axis.id = draft.define(node, "axis");
  const bool linear = node.choice("kind") == "linear";
  axis.kind = linear ? AxisKind::linear : AxisKind::rotary;
  axis.direction = unit_vector(node, "direction");
  const std::string travel_key = linear ? "travel_mm" : "travel_deg";
  const std::string rapid_key = linear ? "rapid_mm_min" : "rapid_deg_min";
  const double unit = linear ? millimetre : degree;
  if (node.has("origin_mm")) axis.origin = point_mm(node, "origin_mm");
  if (linear)
    refuse(node, "endless", "a linear axis has travel_mm = [low, high]");
  else
    axis.endless = node.boolean("endless");
  if (axis.endless) {
    refuse(node, travel_key, "an endless axis has no travel: either of the two");
    axis.high = 2.0 * std::numbers::pi;
  } else {
    const std::vector<double> travel = node.numbers(travel_key);
    if (travel.size() != 2 || !(travel[0] < travel[1])) {
      throw InputError(
          node.place(travel_key),
          travel.size() == 2 ? fmt::format("[{}, {}]", travel[0], travel[1]) : fmt::format("{} numbers", travel.size()),
          "two numbers, low < high");
    }
    axis.low = travel[0] * unit;
    axis.high = travel[1] * unit;
  }
  axis.rapid = node.number(rapid_key) * unit / 60.0;
  if (linear)
    axis.feedback = node.choice_or("feedback", "");
  else
    refuse(node, "feedback", "a linear axis: rotary ones are measured at their table");
  node.finish();
  return axis;
}

SensorSpec read_sensor(const Node& node, Draft& draft) {
  SensorSpec sensor;
  sensor.id = draft.define(node, "sensor");
  sensor.volume = draft.refer_or_empty(node, "volume", "volume");
  sensor.return_of = draft.refer_or_empty(node, "return_of", "coolant");
  sensor.point.setZero();
  if (sensor.volume.empty() && sensor.return_of.empty()) {
    sensor.body = draft.refer(node, "body", "body");
    sensor.point = point_mm(node, "point_mm");
  } else {
    for (const char* key : {"body", "point_mm"})
      refuse(node, key, "a sensor is at a point of a body, in a volume, or in a coolant's return");
    if (!sensor.volume.empty()) refuse(node, "return_of", "either volume or return_of");
  }
  sensor.offset = node.number("offset_K");
  sensor.drift = node.number("drift_K_h") / 3600.0;
  sensor.lag = node.number("time_constant_s");
  sensor.air_share = node.number("air_share");
  sensor.uncertainty = node.number("uncertainty_K");
  node.finish();
  return sensor;
}

TcpSpec read_tcp(const Node& node, Draft& draft) {
  TcpSpec tcp;
  draft.places["tcp tool_surface"] = node.place("tool_surface");
  draft.places["tcp table_surface"] = node.place("table_surface");
  tcp.tool_body = draft.refer(node, "tool_body", "body");
  tcp.tool_surface = draft.refer(node, "tool_surface", "surface");
  tcp.tool_point = point_mm(node, "tool_point_mm");
  tcp.table_body = draft.refer(node, "table_body", "body");
  tcp.table_surface = draft.refer(node, "table_surface", "surface");
  tcp.table_point = point_mm(node, "table_point_mm");
  tcp.table_radius = node.number("table_radius_mm") * millimetre;
  node.finish();
  return tcp;
}

/// Channels are those of measurements, which this file does not know.
ReadingSpec read_reading(const Node& node, Draft& draft) {
  ReadingSpec reading;
  reading.id = node.text("id");
  // A column of a measurement, whose name may hold more than ids of machines do ("dx@1").
  if (reading.id.empty() || reading.id.find_first_of(",;\"\n\r\t ") != std::string::npos)
    throw InputError(node.place("id"), "'" + reading.id + "'", "a name without comma, semicolon, quote or blank");
  std::vector<std::string>& seen = draft.ids["reading"];
  if (std::find(seen.begin(), seen.end(), reading.id) != seen.end())
    throw InputError(node.place("id"), "'" + reading.id + "' a second time", "each id once");
  seen.push_back(reading.id);
  reading.drift = node.number("drift_1_h") / 3600.0;
  reading.shift = node.number("shift_s");
  reading.offset = node.number("offset");
  node.finish();
  return reading;
}

void read_structure(const Node& root, Draft& draft, bool files_must_exist) {
  Machine& machine = draft.machine;
  for (const Node& node : root.tables("material")) machine.materials.push_back(read_material(node, draft));
  for (const Node& node : root.tables("body")) machine.bodies.push_back(read_body(node, draft, files_must_exist));
  for (const Node& node : root.tables("axis")) machine.axes.push_back(read_axis(node, draft));
  for (const Node& node : root.tables("surface")) machine.surfaces.push_back(read_surface_spec(node, draft));
  for (const Node& node : root.tables("joint")) machine.joints.push_back(read_joint(node, draft));
  for (const Node& node : root.tables("scale")) machine.scales.push_back(read_scale(node, draft));
  read_screws(root, draft);
  for (const Node& node : root.tables("sensor")) machine.sensors.push_back(read_sensor(node, draft));
  for (const Node& node : root.tables("reading")) machine.readings.push_back(read_reading(node, draft));
  if (machine.bodies.empty()) throw InputError(root.place(), "no [[body]]", "one or more bodies");
  if (const auto tcp = root.table_if("tcp")) machine.tcp = read_tcp(*tcp, draft);
}

/// Whether the axis moves the tool and not the table, as the B axis of a turning-milling centre.
bool carries_tool_only(const Machine& machine, const std::string& axis) {
  const auto carries = [&](const std::string& id) {
    for (int body = machine.body_index(id); body >= 0; body = machine.body_index(machine.bodies[body].parent))
      if (machine.bodies[body].axis == axis) return true;
    return false;
  };
  return machine.has_tcp() && carries(machine.tcp.tool_body) && !carries(machine.tcp.table_body);
}

void read_workspace(const Node& root, Draft& draft) {
  const auto node = root.table_if("workspace");
  if (!node) return;
  Machine& machine = draft.machine;
  Workspace& workspace = machine.workspace;
  for (const Axis& axis : machine.axes) {  // grid order is the order of the axes, not of the keys
    const bool linear = axis.kind == AxisKind::linear;
    const std::string key = axis.id + (linear ? "_mm" : "_deg");
    if (!node->has(key)) continue;
    std::vector<double> positions = node->numbers(key);
    if (positions.empty()) throw InputError(node->place(key), "an empty list", "one or more positions");
    const double unit = linear ? millimetre : degree;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (i > 0 && !(positions[i] > positions[i - 1])) {
        throw InputError(node->place(key), fmt::format("{} after {}", positions[i], positions[i - 1]),
                         "rising positions");
      }
      const double slack = 1e-9;
      if (!axis.endless && (positions[i] * unit < axis.low - slack || positions[i] * unit > axis.high + slack)) {
        throw InputError(
            node->place(key), fmt::format("{}", positions[i]),
            fmt::format("the travel of axis {}: {:.6g} .. {:.6g}", axis.id, axis.low / unit, axis.high / unit));
      }
    }
    for (double& position : positions) position *= unit;
    const bool tool_side = linear || carries_tool_only(machine, axis.id);
    (tool_side ? workspace.axes : workspace.table_axes).push_back(axis.id);
    (tool_side ? workspace.positions : workspace.table_positions).push_back(std::move(positions));
  }
  node->finish();
}

}  // namespace
}  // namespace reader

namespace {

Machine read(const std::string& text, const std::filesystem::path& path, bool files_must_exist) {
  const core::Config config = core::Config::parse(text, path.string(), &machine_keys());
  const Node root = config.root();
  reader::Draft draft;
  Machine& machine = draft.machine;
  machine.path = path;
  machine.text = text;
  machine.hash = core::content_hash(text);
  root.schema(1);
  machine.name = root.text("name");
  machine.kinematic_chain = root.text("kinematic_chain");
  machine.reference_C = root.number("reference_C");
  if (root.has("plausible_C")) {
    const std::vector<double> range = root.numbers("plausible_C");
    if (range.size() != 2 || !(range[0] >= -273.15 && range[0] < machine.reference_C &&
                               machine.reference_C < range[1] && range[1] <= 2000.0)) {
      throw InputError(
          root.place("plausible_C"),
          range.size() == 2 ? fmt::format("[{}, {}]", range[0], range[1]) : fmt::format("{} numbers", range.size()),
          fmt::format("two temperatures from -273.15 to 2000 degC, one on each side of reference_C = {}",
                      machine.reference_C));
    }
    machine.plausible_low_C = range[0];
    machine.plausible_high_C = range[1];
  }
  machine.require_plausible(machine.reference_C, root.place("reference_C"));
  machine.spindle_max_rpm = root.number("spindle_max_rpm");
  if (const auto sizes = root.table_if("mesh")) {
    machine.coarse = sizes->number("coarse");
    machine.standard = sizes->number("standard");
    machine.fine = sizes->number("fine");
    machine.order = sizes->integer("order");
    machine.lumped_capacity = sizes->choice("capacity") == "lumped";
    sizes->finish();
  }
  reader::read_structure(root, draft, files_must_exist);
  reader::read_physics(root, draft);
  reader::read_workspace(root, draft);
  root.finish();
  reader::check_references(draft);
  reader::check_machine(draft);
  if (!machine.kinematic_chain.empty()) reader::check_chain(draft, root.place("kinematic_chain"));
  reader::check_structure(draft);
  return std::move(draft.machine);
}

}  // namespace

Machine read_machine(const std::filesystem::path& path) { return read(core::read_file(path), path, true); }

Machine parse_machine(const std::string& text, const std::filesystem::path& path) { return read(text, path, false); }

}  // namespace thermotwin::mesh
