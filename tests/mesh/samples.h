// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Small machines and bodies that the tests of this folder share.

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "core/error.h"
#include "mesh/body/tet_mesh.h"
#include "tests/core/temporary_folder.h"

namespace samples {

/// A folder of this test's own, gone afterwards.
class Folder : public thermotwin::core::TemporaryFolder {
public:
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path() / name, std::ios::binary) << text;
    return path() / name;
  }
};

/// What the call throws, or "" if it does not.
inline std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const thermotwin::core::InputError& error) {
    return error.what();
  }
  return {};
}

inline std::string replaced(std::string text, const std::string& old, const std::string& with) {
  const auto at = text.find(old);
  if (at == std::string::npos) throw std::logic_error("sample has no '" + old + "'");
  return text.replace(at, old.size(), with);
}

/// A box of n x n x n cells of six tetrahedra each (Kuhn), size in m.
inline thermotwin::mesh::TetMesh box_mesh(const Eigen::Vector3d& size, int n) {
  using Index = Eigen::Index;
  thermotwin::mesh::TetMesh mesh;
  const auto node = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  mesh.points.resize(3, Index(n + 1) * (n + 1) * (n + 1));
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) mesh.points.col(node(i, j, k)) = Eigen::Vector3d(i, j, k).cwiseProduct(size) / n;
  }
  mesh.tets.resize(4, Index(6) * n * n * n);
  constexpr int walks[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  Index e = 0;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        for (int w = 0; w < 6; ++w) {
          Eigen::Vector3i at(i, j, k);
          Eigen::Vector4i tet;
          tet[0] = node(at[0], at[1], at[2]);
          for (int s = 0; s < 3; ++s) {
            ++at[walks[w][s]];
            tet[s + 1] = node(at[0], at[1], at[2]);
          }
          if (w >= 3) std::swap(tet[1], tet[2]);  // odd walks turn the other way
          mesh.tets.col(e++) = tet;
        }
      }
    }
  }
  return mesh;
}

/// A bed, a slide on X, a swivel B on the slide and a table C on it; a column; a spindle.
inline std::string machine_text() {
  return R"(
schema = 1
name = "small"
reference_C = 21.0
spindle_max_rpm = 12000
[mesh]
coarse = 1.2
[[material]]
id = "iron"
density_kg_m3 = 7200
specific_heat_J_kgK = {value = 500, std_percent = 5}
conductivity_W_mK = 46
expansion_1_K = 11e-6
young_GPa = 120
poisson = 0.26
[[body]]
id = "bed"
material = "iron"
cad = "bed.stl"
element_size_mm = 90
[[body]]
id = "slide"
material = "iron"
cad = "slide.stl"
unit = "m"
element_size_mm = 50
parent = "bed"
axis = "X"
[[body]]
id = "swivel"
material = "iron"
cad = "swivel.stl"
element_size_mm = 50
parent = "slide"
axis = "B"
[[body]]
id = "table"
material = "iron"
cad = "table.stl"
element_size_mm = 50
parent = "swivel"
axis = "C"
[[body]]
id = "screw"
material = "iron"
cad = "screw.stl"
element_size_mm = 50
parent = "bed"
elastic = false
[[axis]]
id = "X"
kind = "linear"
direction = [2, 0, 0]
travel_mm = [-400, 400]
rapid_mm_min = 60000
[[axis]]
id = "B"
kind = "rotary"
direction = [0, 1, 0]
origin_mm = [0, 0, 100]
travel_deg = [-30, 110]
rapid_deg_min = 18000
[[axis]]
id = "C"
kind = "rotary"
direction = [0, 0, 1]
origin_mm = [10, 0, 0]
endless = true
[[surface]]
id = "bed.skin"
body = "bed"
except = ["bed.rails", "bed.feet"]
[[surface]]
id = "bed.rails"
body = "bed"
rule = { plane_point_mm = [0, 0, 50], plane_normal = [0, 0, 1] }
[[surface]]
id = "bed.feet"
body = "bed"
rules = [ { normal = [0, 0, -1], max_angle_deg = 10 }, { box_min_mm = [-1, -1, -1], box_max_mm = [1, 1, 1] } ]
[[surface]]
id = "slide.carriages"
body = "slide"
rule = { group = "carriages" }
[[surface]]
id = "screw.thread"
body = "screw"
rule = { cylinder_point_mm = [0, 0, 0], cylinder_axis = [1, 0, 0], cylinder_radius_mm = 20, tolerance_mm = 1 }
[[surface]]
id = "table.top"
body = "table"
[[joint]]
id = "X_guide"
kind = "guide"
slave = "slide.carriages"
master = "bed.rails"
axis = "X"
conductance_W_m2K = {value = 1500, std_percent = 30}
stiffness_normal_N_mm3 = {value = 300, std_percent = 20}
stiffness_tangential_N_mm3 = 200
reach_mm = 4
divide = [2, 1, 1]
[[joint]]
id = "X_nut"
kind = "screw_nut"
slave = "slide.carriages"
master = "screw.thread"
axis = "X"
conductance_W_m2K = 100
sectors = 8
sector_point_mm = [0, 0, 10]
sector_axis = [3, 0, 0]
[[joint]]
id = "feet"
kind = "mount"
slave = "bed.feet"
ambient = "foundation"
conductance_W_m2K = 50
stiffness_normal_N_mm3 = 100
[[scale]]
axis = "X"
carrier = "bed"
head_body = "slide"
start_mm = [-500, 0, 0]
end_mm = [500, 0, 0]
fixed_at_mm = [0, 0, 0]
head_mm = [0, 0, 5]
expansion_1_K = 10.5e-6
[[ambient]]
id = "air"
default_C = {value = 20, std_percent = 5}
[[ambient]]
id = "foundation"
follows = "air"
offset_K = -1.5
[[film]]
id = "skin"
surfaces = ["bed.skin", "table.top"]
kind = "free_convection"
factor = {value = 1.0, std_percent = 20}
orientation = "up"
emissivity = 0.9
[[film]]
id = "disc"
surfaces = ["table.top"]
kind = "rotating_disc"
axis = "C"
radius_mm = 400
fraction = 0.5
state = "cutting_fluid.on"
[[film]]
id = "wet"
surfaces = ["table.top"]
film_coefficient_W_m2K = {value = 8, std_percent = 50}
[[coolant]]
id = "main"
flow_kg_s = {value = 0.2, std_percent = 10}
guide_sensor = "T1"
[[coolant.segment]]
id = "one"
surface = "table.top"
film_coefficient_W_m2K = 800
volume_l = 0.7
[[source]]
id = "bearing"
drive = "spindle"
drive_loss_share = 0.1
law = [ { input = "spindle.speed_rpm", at = [0, 6000, 12000], power_W = [0, 60, 160] }, { input = "axis.X.feed_mm_min", at = [0, 1], power_W = [0, 2] } ]
place = [ { surface = "table.top", share = 0.4 }, { joint = "X_guide", share = 0.6, slave_share = 0.25 } ]
[[sensor]]
id = "T1"
body = "bed"
point_mm = [1, 2, 3]
offset_K = 0.2
[tcp]
tool_body = "bed"
tool_surface = "bed.rails"
tool_point_mm = [0, 0, 150]
table_body = "table"
table_surface = "table.top"
table_point_mm = [0, 0, 0]
table_radius_mm = 300
[workspace]
X_mm = [-400, 0, 400]
B_deg = [0, 45, 90]
)";
}

}  // namespace samples
