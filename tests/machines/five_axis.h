// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A five-axis machine as a network of lumps: three for each body in a chain, a fluid node, films,
// joints on grids, sources, sensors and outputs at a 27-pose workspace. Small enough to be built by
// hand, with every kind of term and input; a Variation is another machine of the same kind, so that
// what is tested never runs on the equation that made the truth.

#include <cmath>
#include <string>
#include <vector>

#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/output_grid.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::compensation::test {

inline const char* five_axis_text = R"(
schema = 1
name = "lumps"
kinematic_chain = "V [w C' B' b Y X Z (C1) t]"
reference_C = 20.0
spindle_max_rpm = 12000
[[material]]
id = "iron"
density_kg_m3 = 7200
specific_heat_J_kgK = 500
conductivity_W_mK = 46
expansion_1_K = 11e-6
young_GPa = 120
poisson = 0.26
[[axis]]
id = "X"
kind = "linear"
direction = [1, 0, 0]
travel_mm = [-400, 400]
rapid_mm_min = 60000
[[axis]]
id = "Y"
kind = "linear"
direction = [0, 1, 0]
travel_mm = [-300, 300]
rapid_mm_min = 60000
[[axis]]
id = "Z"
kind = "linear"
direction = [0, 0, 1]
travel_mm = [0, 500]
rapid_mm_min = 60000
[[axis]]
id = "B"
kind = "rotary"
direction = [0, 1, 0]
origin_mm = [0, 0, -50]
travel_deg = [-95, 110]
rapid_deg_min = 18000
[[axis]]
id = "C"
kind = "rotary"
direction = [0, 0, 1]
origin_mm = [0, 0, 0]
endless = true
rapid_deg_min = 72000
[[joint]]
id = "mounts"
kind = "mount"
slave = "bed.skin"
ambient = "foundation"
conductance_W_m2K = {value = 100, std_percent = 20}
[[joint]]
id = "foot"
kind = "bolted"
slave = "column.skin"
master = "bed.skin"
conductance_W_m2K = {value = 1500, std_percent = 20}
[[joint]]
id = "Y_guide"
kind = "guide"
slave = "y_slide.skin"
master = "column.skin"
axis = "Y"
conductance_W_m2K = {value = 1500, std_percent = 20}
[[joint]]
id = "X_guide"
kind = "guide"
slave = "x_slide.skin"
master = "y_slide.skin"
axis = "X"
conductance_W_m2K = {value = 1500, std_percent = 20}
[[joint]]
id = "Z_guide"
kind = "guide"
slave = "z_slide.skin"
master = "x_slide.skin"
axis = "Z"
conductance_W_m2K = {value = 1500, std_percent = 20}
[[joint]]
id = "flange"
kind = "bolted"
slave = "spindle.skin"
master = "z_slide.skin"
conductance_W_m2K = {value = 3000, std_percent = 20}
[[joint]]
id = "B_bearing"
kind = "bearing"
slave = "swivel.skin"
master = "bed.skin"
axis = "B"
conductance_W_m2K = {value = 400, std_percent = 20}
[[joint]]
id = "C_bearing"
kind = "bearing"
slave = "table.skin"
master = "swivel.skin"
axis = "C"
conductance_W_m2K = {value = 400, std_percent = 20}
[[ambient]]
id = "air"
default_C = {value = 20, std_percent = 2}
[[ambient]]
id = "foundation"
default_C = {value = 20, std_percent = 2}
[[ambient]]
id = "cutting_fluid"
default_C = {value = 24, std_percent = 5}
[[film]]
id = "structure"
surfaces = ["bed.skin", "column.skin"]
film_coefficient_W_m2K = {value = 8, std_percent = 10}
[[film]]
id = "slides"
surfaces = ["y_slide.skin", "x_slide.skin", "z_slide.skin"]
film_coefficient_W_m2K = {value = 10, std_percent = 10}
[[film]]
id = "head"
surfaces = ["spindle.skin"]
film_coefficient_W_m2K = {value = 12, std_percent = 10}
[[film]]
id = "table_air"
surfaces = ["swivel.skin", "table.skin"]
kind = "rotating_disc"
factor = {value = 1.0, std_percent = 10}
axis = "C"
radius_mm = 300
[[film]]
id = "table_fluid"
surfaces = ["table.skin"]
ambient = "cutting_fluid"
film_coefficient_W_m2K = {value = 150, std_percent = 10}
state = "cutting_fluid.on"
[[coolant]]
id = "main"
flow_kg_s = {value = 0.1, std_percent = 5}
guide_sensor = "T_bed"
guide_offset_K = 0.0
time_constant_s = 120
[[coolant.segment]]
id = "spindle"
surface = "spindle.skin"
film_coefficient_W_m2K = {value = 300, std_percent = 10}
volume_l = 1.0
[[source]]
id = "spindle_bearings"
drive = "spindle"
drive_loss_share = 0.1
scale = {value = 1.0, std_percent = 5}
law = [ { input = "spindle.speed_rpm", at = [0, 6000, 12000], power_W = [0, 150, 450] } ]
place = [ { surface = "spindle.skin" } ]
[[source]]
id = "X_friction"
scale = {value = 1.0, std_percent = 5}
law = [ { input = "axis.X.feed_mm_min", at = [0, 30000], power_W = [0, 120] } ]
place = [ { joint = "X_guide", share = 1.0, slave_share = 0.5 } ]
[[source]]
id = "C_drive"
scale = {value = 1.0, std_percent = 5}
law = [ { input = "axis.C.feed_deg_min", at = [0, 72000], power_W = [0, 250] } ]
place = [ { surface = "table.skin" } ]
)";

inline std::string five_axis_document() {
  std::string text = five_axis_text;
  const auto body = [&](const std::string& id, const std::string& parent, const std::string& axis) {
    text += "[[body]]\nid = \"" + id + "\"\nmaterial = \"iron\"\ncad = \"" + id + ".step\"\nelement_size_mm = 50\n";
    if (!parent.empty()) text += "parent = \"" + parent + "\"\n";
    if (!axis.empty()) text += "axis = \"" + axis + "\"\n";
    text += "[[surface]]\nid = \"" + id + ".skin\"\nbody = \"" + id + "\"\n";
  };
  body("bed", "", "");
  body("column", "bed", "");
  body("y_slide", "column", "Y");
  body("x_slide", "y_slide", "X");
  body("z_slide", "x_slide", "Z");
  body("spindle", "z_slide", "");
  body("swivel", "bed", "B");
  body("table", "swivel", "C");
  const auto sensor = [&](const std::string& id, const std::string& of) {
    text += "[[sensor]]\nid = \"" + id + "\"\nbody = \"" + of + "\"\npoint_mm = [0, 0, 0]\nuncertainty_K = 0.05\n";
  };
  sensor("T_nose", "spindle");
  sensor("T_ram", "z_slide");
  sensor("T_saddle", "x_slide");
  sensor("T_beam", "y_slide");
  sensor("T_column", "column");
  sensor("T_bed", "bed");
  sensor("T_table", "table");
  sensor("T_swivel", "swivel");
  text += R"(
[tcp]
tool_body = "spindle"
tool_surface = "spindle.skin"
tool_point_mm = [0, 0, 150]
table_body = "table"
table_surface = "table.skin"
table_point_mm = [0, 0, 0]
table_radius_mm = 300
[workspace]
X_mm = [-400, 0, 400]
Y_mm = [-300, 0, 300]
Z_mm = [0, 250, 500]
B_deg = [0, 45, 90]
)";
  return text;
}

inline mesh::Machine five_axis_machine() { return mesh::parse_machine(five_axis_document(), "lumps/machine.toml"); }

/// How the lumps differ from nominal: what no parameter of machine.toml expresses.
struct Variation {
  double capacity = 1.0, conduction = 1.0, unevenness = 0.0;
};

inline constexpr int lumps_a_body = 3;

inline reduction::ReducedSystem lumped_system(const mesh::Machine& machine, const Variation& variation = {}) {
  using solver::InputKind;
  using solver::TermKind;
  reduction::ReducedSystem system;
  std::vector<solver::JointGrid> grids;
  for (const mesh::JointSpec& joint : machine.joints) {
    const int axis = joint.axis.empty() ? -1 : machine.axis_index(joint.axis);
    if (axis < 0) {
      grids.push_back({-1, false, {0.0}});
    } else {
      const mesh::Axis& a = machine.axes[axis];
      if (a.endless) {
        grids.push_back({axis, true, {0.0, 2.0943951, 4.1887902}});
      } else {
        grids.push_back({axis, false, {a.low, 0.5 * (a.low + a.high), a.high}});
      }
    }
  }
  system.layout = solver::make_layout(machine, std::move(grids));
  const auto bodies = static_cast<int>(machine.bodies.size());
  const int lumps = bodies * lumps_a_body;
  const int r = lumps + 1;  // the last one is fluid
  const auto lump = [](int body, int i) { return body * lumps_a_body + i; };
  const auto surface_body = [&](const std::string& surface) {
    return machine.body_index(machine.surfaces[machine.surface_index(surface)].body);
  };
  Eigen::VectorXd capacity(r);
  Eigen::MatrixXd conduction = Eigen::MatrixXd::Zero(r, r);
  const auto connect = [](Eigen::MatrixXd& k, int a, int b, double g) {
    k(a, a) += g;
    k(b, b) += g;
    k(a, b) -= g;
    k(b, a) -= g;
  };
  for (int b = 0; b < bodies; ++b) {
    const double size = machine.bodies[b].id == "spindle" ? 1.2e4 : b < 2 ? 2e5 : 5e4;
    for (int i = 0; i < lumps_a_body; ++i) {
      capacity[lump(b, i)] = variation.capacity * size * (1.0 + variation.unevenness * std::sin(3.0 * b + 5.0 * i));
      if (i > 0) {
        connect(conduction, lump(b, i - 1), lump(b, i),
                variation.conduction * 60.0 * (1.0 + variation.unevenness * std::cos(2.0 * b + i)));
      }
    }
  }
  capacity[r - 1] = 0.001 * 815 * 1940;

  std::vector<Eigen::MatrixXd> terms;
  Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(r, std::ssize(system.layout.inputs));
  for (std::size_t t = 0; t < system.layout.terms.size(); ++t) {
    const solver::Term& term = system.layout.terms[t];
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(r, r);
    Eigen::VectorXd ground = Eigen::VectorXd::Zero(r);
    const std::size_t item = term.item;
    if (term.kind == TermKind::film) {
      for (const std::string& surface : machine.films[item].surfaces) {
        const int b = surface_body(surface);
        for (int i = 0; i < lumps_a_body; ++i) ground[lump(b, i)] += machine.bodies[b].id == "spindle" ? 0.2 : 0.8;
      }
      k.diagonal() += ground;
    } else if (term.kind == TermKind::contact) {
      const mesh::JointSpec& joint = machine.joints[item];
      const int slave = lump(surface_body(joint.slave), 0);
      if (joint.master.empty()) {
        ground[slave] = 0.1;
        k.diagonal() += ground;
      } else {
        connect(k, slave, lump(surface_body(joint.master), joint.axis.empty() ? 2 : term.part), 0.02);
      }
    } else if (term.kind == TermKind::coolant_wall) {
      for (int i = 0; i < lumps_a_body; ++i) connect(k, lump(surface_body("spindle.skin"), i), r - 1, 0.03);
    } else {
      k(r - 1, r - 1) = 1940;
      ground[r - 1] = 1940;
    }
    for (std::size_t n = 0; n < system.layout.inputs.size(); ++n) {
      if (system.layout.inputs[n].term == static_cast<int>(t)) inputs.col(n) = ground;
    }
    terms.push_back(std::move(k));
  }
  for (std::size_t n = 0; n < system.layout.inputs.size(); ++n) {
    const solver::Input& input = system.layout.inputs[n];
    if (input.kind != InputKind::source) continue;
    const mesh::SourcePlace& place = machine.sources[input.item].places[input.place];
    auto column = inputs.col(n);
    if (place.joint.empty()) {
      column[lump(surface_body(place.surface), 1)] = 1.0;
    } else {
      const mesh::JointSpec& joint = machine.joints[machine.joint_index(place.joint)];
      column[lump(surface_body(joint.slave), 0)] = place.slave_share;
      column[lump(surface_body(joint.master), input.node)] += 1.0 - place.slave_share;
    }
  }
  Eigen::MatrixXd sensors = Eigen::MatrixXd::Zero(std::ssize(machine.sensors), r);
  for (std::size_t s = 0; s < machine.sensors.size(); ++s) {
    sensors(s, lump(machine.body_index(machine.sensors[s].body), static_cast<int>(s) % lumps_a_body)) = 1.0;
  }
  // States scaled by the root of the capacity, as a reduction leaves them: E = 1.
  const Eigen::VectorXd root = capacity.cwiseSqrt(), inverse = root.cwiseInverse();
  system.capacity = Eigen::MatrixXd::Identity(r, r);
  system.conduction = inverse.asDiagonal() * conduction * inverse.asDiagonal();
  for (const Eigen::MatrixXd& k : terms) system.terms.push_back(inverse.asDiagonal() * k * inverse.asDiagonal());
  system.inputs = inverse.asDiagonal() * inputs;
  system.sensors = sensors * inverse.asDiagonal();
  system.one_kelvin = root;
  return system;
}

/// Rows of some um/K: smooth in the pose, of all bodies of the side. Columns follow the temperatures.
inline reduction::ReducedOutputs lumped_outputs(const mesh::Machine& machine, const reduction::ReducedSystem& system) {
  reduction::ReducedOutputs outputs;
  const auto r = static_cast<int>(system.order());
  const Eigen::VectorXd inverse = system.one_kelvin.cwiseInverse();
  const auto rows = [&](int count, const std::vector<std::string>& bodies, const Eigen::Vector3d& at, double phase) {
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(count, r);
    for (const std::string& id : bodies) {
      const int b = machine.body_index(id);
      for (int i = 0; i < lumps_a_body; ++i) {
        for (int k = 0; k < count; ++k) {
          const double base = std::sin(1.0 + 2.3 * k + 1.7 * b + 0.9 * i + phase);
          c(k, b * lumps_a_body + i) = 2e-6 * base * (1.0 + 0.8 * at[0] - 0.5 * at[1] + at[2] * at[2] * (k + 1));
        }
      }
    }
    return Eigen::MatrixXd(c * inverse.asDiagonal());
  };
  outputs.tool_poses = mesh::workspace_poses(machine);
  for (const mesh::Pose& pose : outputs.tool_poses) {
    outputs.tool.push_back(rows(6, {"bed", "column", "y_slide", "x_slide", "z_slide", "spindle"}, pose.head<3>(), 0.0));
  }
  outputs.table_poses = reduction::OutputGrid(machine).table_poses();
  for (const mesh::Pose& pose : outputs.table_poses) {
    const Eigen::Vector3d tilt(0.0, pose[3], 0.0);
    outputs.table_axis.push_back(rows(6, {"bed", "swivel"}, tilt, 0.4));
    outputs.table_own.push_back(rows(7, {"table"}, tilt, 0.8));
  }
  return outputs;
}

inline reduction::ReducedModel lumped_model(const Variation& variation = {}) {
  reduction::ReducedModel model;
  model.machine = five_axis_machine();
  model.size = "lumps";
  model.system = lumped_system(model.machine, variation);
  model.outputs = lumped_outputs(model.machine, model.system);
  model.full_size = model.system.order();
  return model;
}

}  // namespace thermotwin::compensation::test
