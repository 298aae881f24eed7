// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine of five boxes: bed on its foundation, slide on X with a turning table, column with a
// head on Z that carries spindle and coolant. Every kind of term and input of the equation is in it.

#include <string>

#include "mesh/machine/file.h"
#include "mesh/machine_mesh.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::test {

inline const char* small_machine_text = R"(
schema = 1
name = "boxes"
kinematic_chain = "V [w C X b Z t]"
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
id = "bed"
material = "iron"
cad = "bed.step"
element_size_mm = 90
[[body]]
id = "slide"
material = "iron"
cad = "slide.step"
element_size_mm = 50
parent = "bed"
axis = "X"
[[body]]
id = "table"
material = "iron"
cad = "table.step"
element_size_mm = 50
parent = "slide"
axis = "C"
[[body]]
id = "column"
material = "iron"
cad = "column.step"
element_size_mm = 50
parent = "bed"
[[body]]
id = "head"
material = "iron"
cad = "head.step"
element_size_mm = 50
parent = "column"
axis = "Z"
[[axis]]
id = "X"
kind = "linear"
direction = [1, 0, 0]
travel_mm = [-200, 200]
rapid_mm_min = 30000
[[axis]]
id = "Z"
kind = "linear"
direction = [0, 0, 1]
travel_mm = [-100, 100]
rapid_mm_min = 30000
[[axis]]
id = "C"
kind = "rotary"
direction = [0, 0, 1]
origin_mm = [0, 0, 0]
endless = true
rapid_deg_min = 36000
[[surface]]
id = "bed.top"
body = "bed"
rule = { group = "z1" }
[[surface]]
id = "bed.feet"
body = "bed"
rule = { group = "z0" }
[[surface]]
id = "bed.sides"
body = "bed"
rules = [ { group = "x0" }, { group = "x1" }, { group = "y0" }, { group = "y1" } ]
[[surface]]
id = "slide.carriages"
body = "slide"
rule = { group = "z0" }
[[surface]]
id = "slide.top"
body = "slide"
rule = { group = "z1" }
[[surface]]
id = "slide.sides"
body = "slide"
rules = [ { group = "x0" }, { group = "x1" }, { group = "y0" }, { group = "y1" } ]
[[surface]]
id = "table.seat"
body = "table"
rule = { group = "z0" }
[[surface]]
id = "table.top"
body = "table"
rule = { group = "z1" }
[[surface]]
id = "column.foot"
body = "column"
rule = { group = "z0" }
[[surface]]
id = "column.rails"
body = "column"
rule = { group = "y0" }
[[surface]]
id = "column.sides"
body = "column"
rules = [ { group = "x0" }, { group = "x1" }, { group = "y1" }, { group = "z1" } ]
[[surface]]
id = "head.carriages"
body = "head"
rule = { group = "y1" }
[[surface]]
id = "head.nose"
body = "head"
rule = { group = "z0" }
[[surface]]
id = "head.jacket"
body = "head"
rules = [ { group = "x0" }, { group = "x1" } ]
[[surface]]
id = "head.front"
body = "head"
rules = [ { group = "y0" }, { group = "z1" } ]
[[joint]]
id = "feet"
kind = "mount"
slave = "bed.feet"
ambient = "foundation"
conductance_W_m2K = 20
stiffness_normal_N_mm3 = 20
stiffness_tangential_N_mm3 = 20
divide = [2, 2, 1]
[[joint]]
id = "foot"
kind = "bolted"
slave = "column.foot"
master = "bed.top"
conductance_W_m2K = 3000
stiffness_normal_N_mm3 = 500
stiffness_tangential_N_mm3 = 500
divide = [2, 2, 1]
[[joint]]
id = "X_guide"
kind = "guide"
slave = "slide.carriages"
master = "bed.top"
axis = "X"
conductance_W_m2K = 800
stiffness_normal_N_mm3 = 300
stiffness_tangential_N_mm3 = 200
divide = [2, 2, 1]
[[joint]]
id = "X_drive"
kind = "screw_nut"
slave = "slide.carriages"
master = "bed.top"
axis = "X"
conductance_W_m2K = 100
stiffness_normal_N_mm3 = 30
stiffness_tangential_N_mm3 = 300
[[joint]]
id = "Z_guide"
kind = "bolted"
slave = "head.carriages"
master = "column.rails"
axis = "Z"
conductance_W_m2K = 800
stiffness_normal_N_mm3 = 300
stiffness_tangential_N_mm3 = 200
divide = [2, 1, 2]
[[joint]]
id = "C_bearing"
kind = "bearing"
slave = "table.seat"
master = "slide.top"
axis = "C"
conductance_W_m2K = 500
stiffness_normal_N_mm3 = 300
stiffness_tangential_N_mm3 = 300
divide = [2, 2, 1]
[[ambient]]
id = "air"
default_C = 20
[[ambient]]
id = "foundation"
follows = "air"
[[ambient]]
id = "cutting_fluid"
follows = "air"
offset_K = 1
[[film]]
id = "sides"
surfaces = ["bed.sides", "slide.sides", "column.sides", "head.front"]
kind = "free_convection"
factor = 1.0
length_m = 0.4
emissivity = 0.9
[[film]]
id = "disc"
surfaces = ["table.top"]
kind = "rotating_disc"
axis = "C"
radius_mm = 120
[[film]]
id = "wet"
surfaces = ["table.top"]
ambient = "cutting_fluid"
film_coefficient_W_m2K = 200
state = "cutting_fluid.on"
[[coolant]]
id = "main"
flow_kg_s = 0.05
guide_sensor = "T1"
time_constant_s = 120
[[coolant.segment]]
id = "head"
surface = "head.jacket"
film_coefficient_W_m2K = 300
volume_l = 0.3
[[coolant.segment]]
id = "rails"
surface = "head.carriages"
film_coefficient_W_m2K = 100
volume_l = 0.2
[[source]]
id = "bearing"
drive = "spindle"
drive_loss_share = 0.2
law = [ { input = "spindle.speed_rpm", at = [0, 6000, 12000], power_W = [0, 60, 150] } ]
place = [ { surface = "head.nose" } ]
[[source]]
id = "X_friction"
law = [ { input = "axis.X.feed_mm_min", at = [0, 30000], power_W = [0, 80] } ]
place = [ { joint = "X_guide", share = 1.0, slave_share = 0.5 } ]
[[sensor]]
id = "T1"
body = "bed"
point_mm = [350, 0, -100]
[[sensor]]
id = "T2"
body = "head"
point_mm = [0, 100, 200]
[tcp]
tool_body = "head"
tool_surface = "head.nose"
tool_point_mm = [0, 0, 240]
table_body = "table"
table_surface = "table.top"
table_point_mm = [0, 0, 200]
table_radius_mm = 100
[workspace]
X_mm = [-200, 0, 200]
Z_mm = [-100, 0, 100]
)";

inline mesh::Machine small_machine() { return mesh::parse_machine(small_machine_text, "boxes/machine.toml"); }

/// @param finer  divides the elements
inline mesh::MachineMesh small_machine_mesh(int finer = 1) {
  const auto box = [finer](const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3i& cells) {
    return box_mesh(low, high, cells * finer);
  };
  return machine_mesh(
      small_machine(),
      {box({-0.4, -0.2, -0.2}, {0.4, 0.4, 0.0}, {6, 5, 2}), box({-0.15, -0.15, 0.0}, {0.15, 0.15, 0.15}, {3, 3, 2}),
       box({-0.12, -0.12, 0.15}, {0.12, 0.12, 0.2}, {3, 3, 1}), box({-0.12, 0.2, 0.0}, {0.12, 0.38, 0.55}, {2, 2, 5}),
       box({-0.1, 0.05, 0.25}, {0.1, 0.2, 0.4}, {2, 2, 2})});
}

/// A machine's mesh with its equations.
inline solver::FullModel full_model(mesh::MachineMesh mesh) {
  solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
  solver::ElasticModel elastic(mesh, thermal);
  return {std::move(mesh), std::move(thermal), std::move(elastic)};
}

/// @param finer  as small_machine_mesh takes it
inline solver::FullModel boxes(int finer = 1) { return full_model(small_machine_mesh(finer)); }

}  // namespace thermotwin::test
