// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The boxes of boxes.h with a scale on Z, a screw on X, more sensors and stated
// uncertainties: full models, a reduced one, and measurements of machines that differ.

#include <stdexcept>
#include <string>

#include "compensation/measurement/virtual_measurement.h"
#include "core/file.h"
#include "core/progress.h"
#include "mesh/machine/file.h"
#include "mesh/selection.h"
#include "reduction/basis/reduce.h"
#include "solver/campaign/full_model.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/boxes.h"

namespace meshed {

using namespace thermotwin;

inline std::string replaced(std::string text, const std::string& old, const std::string& now) {
  const std::size_t at = text.find(old);
  if (at == std::string::npos) throw std::logic_error("no '" + old + "'");
  return text.replace(at, old.size(), now);
}

inline std::string machine_text() {
  std::string text = test::small_machine_text;
  text = replaced(text, "id = \"X\"\nkind = \"linear\"\n", "id = \"X\"\nkind = \"linear\"\nfeedback = \"screw\"\n");
  text = replaced(text, "id = \"Z_guide\"\nkind = \"bolted\"\n", "id = \"Z_guide\"\nkind = \"guide\"\n");
  text = replaced(text, "conductance_W_m2K = 100\nstiffness_normal_N_mm3 = 30\nstiffness_tangential_N_mm3 = 300\n",
                  "conductance_W_m2K = 100\n");
  for (const char* power : {"id = \"bearing\"\n", "id = \"X_friction\"\n"})
    text = replaced(text, power, std::string(power) + "scale = {value = 1.0, std_percent = 5}\n");
  text = replaced(text, "conductance_W_m2K = 800\n", "conductance_W_m2K = {value = 800, std_percent = 20}\n");
  return text + R"(
[[body]]
id = "x_screw"
material = "iron"
cad = "x_screw.step"
element_size_mm = 40
parent = "bed"
elastic = false
[[surface]]
id = "x_screw.skin"
body = "x_screw"
[[joint]]
id = "X_nut"
kind = "screw_nut"
slave = "slide.carriages"
master = "x_screw.skin"
axis = "X"
conductance_W_m2K = 400
[[screw]]
axis = "X"
body = "x_screw"
nut_body = "slide"
fixed_bearing_mm = [-300, 0, -10]
nut_mm = [0, 0, -10]
expansion_1_K = 11.5e-6
[[scale]]
axis = "Z"
carrier = "column"
head_body = "head"
start_mm = [100, 200, 100]
end_mm = [100, 200, 500]
fixed_at_mm = [100, 200, 100]
head_mm = [100, 190, 330]
expansion_1_K = 10.5e-6
[[source]]
id = "X_screw"
scale = {value = 1.0, std_percent = 5}
law = [ { input = "axis.X.feed_mm_min", at = [0, 30000], power_W = [0, 60] } ]
place = [ { surface = "x_screw.skin" } ]
[[sensor]]
id = "T3"
body = "column"
point_mm = [0, 380, 400]
[[sensor]]
id = "T4"
body = "slide"
point_mm = [140, 0, 100]
[[sensor]]
id = "T5"
body = "x_screw"
point_mm = [300, 0, -10]
[[sensor]]
id = "T6"
body = "bed"
point_mm = [-390, 0, -100]
[[sensor]]
id = "T7"
body = "column"
point_mm = [0, 230, 100]
[[sensor]]
id = "T8"
body = "bed"
point_mm = [100, 390, -50]
)";
}

inline mesh::Machine machine() { return mesh::parse_machine(machine_text(), "boxes/machine.toml"); }

/// @param finer  divides the elements
inline solver::FullModel full_model(const mesh::Machine& machine, int finer = 1) {
  mesh::MachineMesh plain = test::small_machine_mesh(finer);
  std::vector<mesh::TetMesh> bodies = std::move(plain.bodies);
  bodies.push_back(test::box_mesh({-0.35, -0.015, -0.02}, {0.35, 0.015, 0.0}, finer * Eigen::Vector3i(14, 1, 1)));
  mesh::MachineMesh mesh;
  mesh.machine = machine;
  mesh.first_node.push_back(0);
  for (const mesh::TetMesh& body : bodies) mesh.first_node.push_back(mesh.first_node.back() + body.nodes());
  mesh.surfaces = mesh::resolve_surfaces(machine, bodies);
  mesh.bodies = std::move(bodies);
  return test::full_model(std::move(mesh));
}

/// @param starts_at  time of day, e.g. "06:00"; empty: none
inline solver::LoadProgram load(const mesh::Machine& machine, const std::string& name, const std::string& phases,
                                const std::string& starts_at = "") {
  const core::TemporaryFolder scratch;
  core::set_quiet(true);
  const auto file = scratch.path() / (name + ".toml");
  core::write_file(
      file, "schema = 1\ninitial_C = 20.0\ntime_step_s = 120\noutput_s = 600\nposition = { X_mm = 0, Z_mm = 0 }\n" +
                (starts_at.empty() ? "" : "starts_at = \"" + starts_at + "\"\n") + phases);
  return solver::LoadProgram::read(file, machine);
}

/// Spindle, X and rest, twice.
inline const char* const shift = R"(
[[phase]]
name = "spindle"
duration_h = 3
spindle_rpm = 9000
air_C = [20.0, 22.0]
[[phase]]
name = "X"
duration_h = 3
spindle_rpm = 0
[[phase.axis]]
id = "X"
low_mm = -150
high_mm = 150
feed_mm_min = 25000
[[phase]]
name = "rest"
duration_h = 2
air_C = [22.0, 21.0]
[[phase]]
name = "both"
duration_h = 3
spindle_rpm = 6000
[[phase.axis]]
id = "X"
low_mm = 0
high_mm = 200
feed_mm_min = 15000
[[phase]]
name = "rest"
duration_h = 3
spindle_rpm = 0
)";

/// The nominal machine, reduced.
inline const reduction::ReducedModel& reduced() {
  static const reduction::ReducedModel model = [] {
    core::set_quiet(true);
    return reduction::reduce(full_model(machine()), {}, {}, {.order = 90});
  }();
  return model;
}

}  // namespace meshed
