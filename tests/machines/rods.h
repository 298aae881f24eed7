// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine of three rods (base, column, head) as a network of cells, small enough for thousands of
// runs: a reduced model of any fineness from the same machine.toml. Records of it: rods_record.h.

#include <algorithm>
#include <string>
#include <vector>

#include "mesh/machine/file.h"
#include "reduction/model/output_grid.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"

namespace lumped {

using namespace thermotwin;
using Eigen::Index;

inline std::string machine_text() {
  return R"(# three rods
schema = 1
name = "rods"
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

[[body]]
id = "base"
material = "iron"
cad = "base.step"
element_size_mm = 90
[[body]]
id = "column"
material = "iron"
cad = "column.step"
element_size_mm = 90
parent = "base"
[[body]]
id = "head"
material = "iron"
cad = "head.step"
element_size_mm = 90
parent = "column"
axis = "Z"

[[axis]]
id = "Z"
kind = "linear"
direction = [0, 0, 1]
travel_mm = [0, 400]

[[surface]]
id = "base.skin"
body = "base"
[[surface]]
id = "base.feet"
body = "base"
[[surface]]
id = "column.skin"
body = "column"
[[surface]]
id = "column.rails"
body = "column"
[[surface]]
id = "head.skin"
body = "head"
[[surface]]
id = "head.carriages"
body = "head"
[[surface]]
id = "head.channel"
body = "head"
[[surface]]
id = "head.motor"
body = "head"
[[surface]]
id = "column.pump"
body = "column"

[[joint]]
id = "foot"
kind = "bolted"
slave = "column.skin"
master = "base.skin"
conductance_W_m2K = {value = 1200, std_percent = 10}
[[joint]]
id = "Z_guide"
kind = "guide"
slave = "head.carriages"
master = "column.rails"
axis = "Z"
conductance_W_m2K = {value = 1500, std_percent = 10}
[[joint]]
id = "mounts"
kind = "mount"
slave = "base.feet"
ambient = "foundation"
conductance_W_m2K = { value = 400, std_percent = 10 }

[[ambient]]
id = "air"
default_C = {value = 20, std_percent = 1}
[[ambient]]
id = "foundation"
follows = "air"
offset_K = -0.5

[[film]]
id = "base.film"
surfaces = ["base.skin"]
film_coefficient_W_m2K = {value = 9, std_percent = 10} # still air
[[film]]
id = "column.film"
surfaces = ["column.skin"]
film_coefficient_W_m2K = {value = 9, std_percent = 10}
[[film]]
id = "head.film"
surfaces = ["head.skin"]
kind = "free_convection"
orientation = "vertical"
emissivity = 0.9

[[coolant]]
id = "main"
flow_kg_s = {value = 0.05, std_percent = 10}
guide_sensor = "T1"
[[coolant.segment]]
id = "jacket"
surface = "head.channel"
film_coefficient_W_m2K = {value = 60, std_percent = 10}
volume_l = 0.7

[[source]]
id = "motor"
scale = {value = 1.0, std_percent = 5}
law = [
  { input = "spindle.speed_rpm", at = [0, 6000, 12000], power_W = [0, 110, 260] },  # [table]
]
place = [ { surface = "head.motor", share = 0.9 } ]
[[source]]
id = "guide_friction"
law = [ { input = "axis.Z.feed_mm_min", at = [0, 20000], power_W = [0, 120] } ]
place = [ { joint = "Z_guide", share = 1.0, slave_share = 0.4 } ]
[[source]]
id = "pump"
law = [ { input = "machine.on", at = [0, 1], power_W = [0, 40] } ]
place = [ { surface = "column.pump" } ]

[[sensor]]
id = "T1"
body = "base"
point_mm = [0, 0, 500]
[[sensor]]
id = "T2"
body = "column"
point_mm = [0, 0, 250]
[[sensor]]
id = "T3"
body = "column"
point_mm = [0, 0, 850]
offset_K = 0.1   # calibrated
[[sensor]]
id = "T4"
body = "head"
point_mm = [0, 0, 300]
[[sensor]]
id = "T5"
body = "head"
point_mm = [0, 0, 900]
[[sensor]]
id = "T6"
body = "base"
point_mm = [0, 0, 100]

[tcp]
tool_body = "head"
tool_surface = "head.motor"
tool_point_mm = [0, 0, 0]
table_body = "base"
table_surface = "base.skin"
table_point_mm = [0, 0, 0]

[workspace]
Z_mm = [0, 200, 400]
)";
}

inline mesh::Machine machine() { return mesh::parse_machine(machine_text(), "rods/machine.toml"); }

/// Sizes of a rod.
struct Rod {
  double length, section, skin;  ///< m, m^2, m^2
};
inline const std::vector<Rod> rods = {{1.0, 0.24, 2.2}, {1.2, 0.08, 1.5}, {0.6, 0.06, 0.7}};

/// @param cells  nodes a rod
inline reduction::ReducedModel model(const mesh::Machine& m, int cells) {
  const Index n = cells;
  const Index fluid = 3 * n, size = fluid + 1;
  const double rho = 7200, heat = 500, k = 46, alpha = 11e-6;
  reduction::ReducedModel result;
  result.machine = m;
  result.size = "network of " + std::to_string(cells) + " nodes a rod";
  result.full_size = size;
  reduction::ReducedSystem& s = result.system;
  std::vector<solver::JointGrid> grids(3);
  for (auto& grid : grids) grid.positions = {0.0};
  grids[1].axis = 0;
  grids[1].positions = {0.0, 0.2, 0.4};
  s.layout = solver::make_layout(m, grids);
  s.capacity.setZero(size, size);
  s.conduction.setZero(size, size);
  // Linear elements, nodes at both ends of a rod, lumped capacity.
  const auto node_share = [&](Index i) { return (i == 0 || i + 1 == n ? 0.5 : 1.0) / (cells - 1); };
  for (Index b = 0; b < 3; ++b) {
    const Rod& rod = rods[b];
    const double g = k * rod.section * (cells - 1) / rod.length;
    for (Index i = 0; i < n; ++i) {
      s.capacity(b * n + i, b * n + i) = rho * heat * rod.section * rod.length * node_share(i);
      if (i + 1 == n) continue;
      const Index a = b * n + i, c = a + 1;
      s.conduction(a, a) += g, s.conduction(c, c) += g, s.conduction(a, c) -= g, s.conduction(c, a) -= g;
    }
  }
  s.capacity(fluid, fluid) = 0.7e-3 * 815 * 1940;
  // A spot at a share of a rod's length, spread over the two nodes next to it.
  const auto spot = [&](Index rod, double share) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
    const double at = std::clamp(share * (cells - 1), 0.0, cells - 1.0);
    const auto left = std::min(static_cast<Index>(at), n - 2);
    row[rod * n + left] = 1.0 - (at - left);
    row[rod * n + left + 1] = at - left;
    return row;
  };
  const auto skin = [&](Index rod) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
    for (Index i = 0; i < n; ++i) row[rod * n + i] = rods[rod].skin * node_share(i);
    return row;
  };
  const Eigen::VectorXd wet = Eigen::VectorXd::Unit(size, fluid);
  const auto exchange = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b, double area) {
    return Eigen::MatrixXd(area * (a - b) * (a - b).transpose());
  };
  const std::vector<double> z = {0.25, 0.5, 0.75};  // where the head hangs on the column
  for (const solver::Term& term : s.layout.terms) {
    if (term.kind == solver::TermKind::film) {
      s.terms.push_back(skin(term.item).asDiagonal());
    } else if (term.kind == solver::TermKind::coolant_wall) {
      s.terms.push_back(exchange(spot(2, 0.75), wet, 0.5));
    } else if (term.kind == solver::TermKind::coolant_flow) {
      s.terms.push_back(1940.0 * wet * wet.transpose());
    } else if (term.item == 0) {
      s.terms.push_back(exchange(spot(0, 1.0), spot(1, 0.0), 0.05));
    } else if (term.item == 1) {
      s.terms.push_back(exchange(spot(2, 0.25), spot(1, z[term.part]), 0.02));
    } else {
      s.terms.push_back(0.08 * spot(0, 0.125) * spot(0, 0.125).transpose());
    }
  }
  s.inputs.setZero(size, std::ssize(s.layout.inputs));
  for (Index i = 0; i < s.inputs.cols(); ++i) {
    const solver::Input& input = s.layout.inputs[i];
    if (input.kind == solver::InputKind::source) {
      const mesh::SourcePlace& place = m.sources[input.item].places[input.place];
      if (!place.joint.empty())
        s.inputs.col(i) = place.slave_share * spot(2, 0.25) + (1 - place.slave_share) * spot(1, z[input.node]);
      else
        s.inputs.col(i) = place.surface == "head.motor"  ? spot(2, 1.0)
                          : place.surface == "base.skin" ? spot(0, 0.5)
                                                         : spot(1, 0.125);
    } else if (input.kind == solver::InputKind::film_ambient) {
      s.inputs.col(i) = skin(input.item);
    } else if (input.kind == solver::InputKind::film_gradient) {
      // The base lies at the height of the air's reference, the column stands on it, the head hangs half way up.
      s.inputs.col(i) = skin(input.item);
      const double of_head = input.item == 2 ? 0.6 : 0.0;
      for (Index node = 0; node < n; ++node)
        s.inputs(input.item * n + node, i) *= input.item == 1 ? rods[1].length * node / (cells - 1) : of_head;
    } else if (input.kind == solver::InputKind::contact_ambient) {
      s.inputs.col(i) = 0.08 * spot(0, 0.125);
    } else {
      s.inputs.col(i) = 1940.0 * wet;
    }
  }
  s.sensors.resize(std::ssize(m.sensors), size);
  for (Index i = 0; i < s.sensors.rows(); ++i) {
    const mesh::SensorSpec& sensor = m.sensors[i];
    s.sensors.row(i) = spot(m.body_index(sensor.body), sensor.point.z()).transpose();
  }
  s.one_kelvin = Eigen::VectorXd::Ones(size);
  // Column up to the head, head down to the tool, base below the table; x by the head's gradient.
  for (int p = 0; p < 3; ++p) {
    result.outputs.tool_poses.push_back(Eigen::VectorXd::Constant(1, 0.2 * p));
    Eigen::MatrixXd tool = Eigen::MatrixXd::Zero(6, size);
    // The column grows up to where the head hangs: straight lines between the nodes, exactly.
    const double top = z[p];
    for (Index e = 0; e + 1 < n; ++e) {
      const double low = static_cast<double>(e) / (cells - 1), width = 1.0 / (cells - 1);
      const double part = std::clamp((top - low) / width, 0.0, 1.0);
      tool(2, n + e + 1) += alpha * rods[1].length * width * 0.5 * part * part;
      tool(2, n + e) += alpha * rods[1].length * width * (part - 0.5 * part * part);
    }
    for (Index i = 0; i < n; ++i) {
      const double share = static_cast<double>(i) / (cells - 1);
      tool(2, 2 * n + i) = -alpha * rods[2].length * node_share(i);
      tool(0, 2 * n + i) = 0.8 * alpha * rods[2].length * node_share(i) * (share - 0.4);
      tool(0, n + i) = 0.5 * alpha * rods[1].length * node_share(i) * (share - 0.5);
    }
    result.outputs.tool.push_back(tool);
  }
  result.outputs.table_poses = reduction::OutputGrid(m).table_poses();
  Eigen::MatrixXd table = Eigen::MatrixXd::Zero(6, size);
  for (Index i = 0; i < n; ++i) table(2, i) = 0.4 * alpha * node_share(i), table(0, i) = 0.1 * alpha * node_share(i);
  result.outputs.table_axis = {table};
  result.outputs.table_own = {Eigen::MatrixXd::Zero(7, size)};
  return result;
}

}  // namespace lumped
