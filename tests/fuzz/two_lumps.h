// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A slide on a bed, a lump of heat each, with a guide, a film, a source and two sensors: a reduced model of order two,
// so that a compensator is made and stepped in well under a millisecond.

#include <vector>

#include "reduction/output_grid.h"
#include "reduction/reduced_model.h"

namespace thermotwin::test {

inline const char* two_lumps_text = R"(
schema = 1
name = "two lumps"
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
element_size_mm = 50
[[body]]
id = "slide"
material = "iron"
cad = "slide.step"
element_size_mm = 50
parent = "bed"
axis = "X"
[[surface]]
id = "bed.skin"
body = "bed"
[[surface]]
id = "slide.skin"
body = "slide"
[[axis]]
id = "X"
kind = "linear"
direction = [1, 0, 0]
travel_mm = [-400, 400]
rapid_mm_min = 60000
[[joint]]
id = "guide"
kind = "guide"
slave = "slide.skin"
master = "bed.skin"
axis = "X"
conductance_W_m2K = {value = 1500, std_percent = 20}
[[ambient]]
id = "air"
default_C = {value = 20, std_percent = 2}
[[film]]
id = "skin"
surfaces = ["bed.skin", "slide.skin"]
film_coefficient_W_m2K = {value = 10, std_percent = 10}
[[source]]
id = "bearings"
drive = "spindle"
drive_loss_share = 0.1
scale = {value = 1.0, std_percent = 5}
law = [ { input = "spindle.speed_rpm", at = [0, 12000], power_W = [0, 450] } ]
place = [ { surface = "slide.skin" } ]
[[sensor]]
id = "T_slide"
body = "slide"
point_mm = [0, 0, 0]
uncertainty_K = 0.05
[[sensor]]
id = "T_bed"
body = "bed"
point_mm = [0, 0, 0]
uncertainty_K = 0.05
[tcp]
tool_body = "slide"
tool_surface = "slide.skin"
tool_point_mm = [0, 0, 150]
table_body = "bed"
table_surface = "bed.skin"
table_point_mm = [0, 0, 0]
table_radius_mm = 300
[workspace]
X_mm = [-400, 0, 400]
)";

inline reduction::ReducedModel two_lumps() {
  reduction::ReducedModel model;
  model.machine = mesh::parse_machine(two_lumps_text, "two_lumps/machine.toml");
  model.size = "lumps";
  model.full_size = 2;
  reduction::ReducedSystem& system = model.system;
  system.layout = solver::make_layout(model.machine, {{0, false, {-0.4, 0.0, 0.4}}});
  const Eigen::Vector2d capacity(2e5, 5e4), inverse = capacity.cwiseSqrt().cwiseInverse();  // bed, slide; states with E = 1
  const auto scaled = [&](const Eigen::Matrix2d& k) { return Eigen::MatrixXd(inverse.asDiagonal() * k * inverse.asDiagonal()); };
  const Eigen::Matrix2d between{{1.0, -1.0}, {-1.0, 1.0}};
  system.capacity = Eigen::MatrixXd::Identity(2, 2);
  system.conduction = Eigen::MatrixXd::Zero(2, 2);
  system.inputs = Eigen::MatrixXd::Zero(2, static_cast<Eigen::Index>(system.layout.inputs.size()));
  for (std::size_t t = 0; t < system.layout.terms.size(); ++t) {
    const bool film = system.layout.terms[t].kind == solver::TermKind::film;
    const Eigen::Vector2d area(1.6, 0.8);
    system.terms.push_back(scaled(film ? Eigen::Matrix2d(area.asDiagonal()) : Eigen::Matrix2d(0.02 * between)));
    for (std::size_t n = 0; n < system.layout.inputs.size(); ++n)
      if (film && system.layout.inputs[n].term == static_cast<int>(t))
        system.inputs.col(static_cast<Eigen::Index>(n)) = inverse.cwiseProduct(area);
  }
  for (std::size_t n = 0; n < system.layout.inputs.size(); ++n)
    if (system.layout.inputs[n].kind == solver::InputKind::source)
      system.inputs(1, static_cast<Eigen::Index>(n)) = inverse[1];
  system.sensors = Eigen::Matrix2d{{0.0, 1.0}, {1.0, 0.0}} * inverse.asDiagonal();
  system.one_kelvin = inverse.cwiseInverse();
  const auto rows = [&](Eigen::Index count, Eigen::Index lump, double at) {
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(count, 2);
    c.col(lump).setLinSpaced(1e-6, 5e-6 * (1.0 + 0.5 * at));
    return Eigen::MatrixXd(c * inverse.asDiagonal());
  };
  model.outputs.tool_poses = mesh::workspace_poses(model.machine);
  for (const mesh::Pose& pose : model.outputs.tool_poses) model.outputs.tool.push_back(rows(6, 1, pose[0]));
  model.outputs.table_poses = reduction::OutputGrid(model.machine).table_poses();
  for (const mesh::Pose& pose : model.outputs.table_poses) {
    model.outputs.table_axis.push_back(rows(6, 0, pose[0]));
    model.outputs.table_own.push_back(rows(7, 0, pose[0]));
  }
  return model;
}

}  // namespace thermotwin::test
