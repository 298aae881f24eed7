// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A bed with a slide on it, meshes that do not match: every kind of term and input of the thermal
// equation once or more, small enough to check against dense or direct solutions.

#include "mesh/machine_mesh.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::test {

inline mesh::SourceSpec source(const std::string& id, const std::string& input, const std::vector<double>& at,
                               const std::vector<double>& power, const std::vector<mesh::SourcePlace>& places) {
  mesh::SourceSpec s;
  s.id = id;
  s.laws = {{input, at, power}};
  s.places = places;
  return s;
}

inline mesh::SourcePlace on_surface(const std::string& id, double share = 1.0) {
  mesh::SourcePlace p;
  p.surface = id;
  p.share = share;
  return p;
}

inline mesh::SourcePlace at_joint(const std::string& id, double share, double slave_share) {
  mesh::SourcePlace p;
  p.joint = id;
  p.share = share;
  p.slave_share = slave_share;
  return p;
}

inline mesh::Machine slide_machine() {
  mesh::Machine m;
  m.name = "slide";
  m.reference_C = 20.0;
  m.spindle_max_rpm = 12000;
  m.materials = {steel()};
  m.bodies = {body("bed"), body("slide", "steel", "bed", "X")};
  m.axes = {linear_axis("X", Eigen::Vector3d::UnitX(), -0.2, 0.2)};
  m.surfaces = {surface("bed.rail", "bed", {"z1"}),
                surface("bed.feet", "bed", {"z0"}),
                surface("bed.skin", "bed", {"x0", "x1", "y0", "y1"}),
                surface("slide.pad", "slide", {"z0"}),
                surface("slide.top", "slide", {"z1"}),
                surface("slide.left", "slide", {"y0"}),
                surface("slide.right", "slide", {"y1"}),
                surface("slide.front", "slide", {"x1"})};
  m.ambients = {ambient("air", 20.0), ambient("foundation", 20.0, "air", -1.0), ambient("cutting_fluid", 24.0)};
  mesh::FilmSpec skin = constant_film("bed.skin", {"bed.skin"}, 1.0);
  skin.kind = mesh::FilmKind::free_convection;
  skin.emissivity.value = 0.9;
  mesh::FilmSpec wet = constant_film("slide.top", {"slide.top"}, 300.0, "cutting_fluid");
  wet.state = "cutting_fluid.on";
  mesh::FilmSpec disc = constant_film("slide.front", {"slide.front"}, 1.0);
  disc.kind = mesh::FilmKind::rotating_disc;
  disc.axis = "spindle";
  disc.radius = 0.2;
  disc.fraction = 0.3;
  m.films = {skin, wet, disc};
  mesh::JointSpec guide;
  guide.id = "X_guide";
  guide.kind = "guide";
  guide.slave = "slide.pad";
  guide.master = "bed.rail";
  guide.axis = "X";
  guide.conductance = {1500.0, 0.0};
  mesh::JointSpec mount;
  mount.id = "mount";
  mount.kind = "mount";
  mount.slave = "bed.feet";
  mount.ambient = "foundation";
  mount.conductance = {50.0, 0.0};
  m.joints = {guide, mount};
  mesh::CoolantSpec coolant;
  coolant.id = "main";
  coolant.flow = {0.02, 0.0};
  coolant.guide_sensor = "T1";
  coolant.segments = {{"left", "slide.left", {800.0, 0.0}, 1e-4},
                      {"right", "slide.right", {600.0, 0.0}, 2e-4, 1, {"left"}}};
  m.coolants = {coolant};
  m.sources = {source("motor", "spindle.speed_rpm", {0, 6000, 12000}, {0, 100, 240},
                      {on_surface("slide.front", 0.4), at_joint("X_guide", 0.5, 0.3)}),
               source("friction", "axis.X.feed_mm_min", {0, 30000}, {0, 90}, {at_joint("X_guide", 1.0, 0.5)}),
               source("cabinet", "machine.on", {0, 1}, {0, 40}, {on_surface("bed.skin")})};
  mesh::SensorSpec t1, t2;
  t1.id = "T1";
  t1.body = "bed";
  t1.point = {0.31, 0.047, 0.033};
  t2.id = "T2";
  t2.body = "slide";
  t2.point = {0.3, 0.06, 0.5};  // above the slide: taken at its top
  m.sensors = {t1, t2};
  m.workspace.axes = {"X"};
  m.workspace.positions = {{-0.2, 0.0, 0.2}};
  return m;
}

/// @param refine  multiplies the number of cells along each edge
inline mesh::MachineMesh slide_mesh(int refine = 1, mesh::Machine machine = slide_machine()) {
  return machine_mesh(std::move(machine),
                      {box_mesh({0, 0, 0}, {0.6, 0.12, 0.1}, refine * Eigen::Vector3i(9, 3, 2)),
                       box_mesh({0.25, 0.01, 0.101}, {0.35, 0.11, 0.16}, refine * Eigen::Vector3i(4, 5, 2))});
}

}  // namespace thermotwin::test
