// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine of five boxes for elastic tests: bed on mounts, slide on X with a turning table, column
// with a head on Z; guides, a bearing, a bolted joint and two scales.

#include "mesh/machine/kinematics.h"
#include "solver/elastic/model.h"
#include "solver/thermal/system.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::test {

struct BoxMachineOptions {
  double mount_normal = 25e9, mount_tangential = 5e9;  ///< N/m^3
  double tape_expansion = 11.5e-6;                     ///< 1/K, of both scales
  int finer = 1;                                       ///< divides the elements
};

inline mesh::JointSpec elastic_joint(const std::string& id, const std::string& kind, const std::string& slave,
                                     const std::string& master, const std::string& axis,
                                     const Eigen::Vector3i& divide) {
  mesh::JointSpec joint;
  joint.id = id;
  joint.kind = kind;
  joint.slave = slave;
  joint.master = master;
  joint.axis = axis;
  if (master.empty()) joint.ambient = "foundation";
  joint.conductance = {1000.0, 0.0};
  joint.stiffness_normal = {300e9, 0.0};
  joint.stiffness_tangential = {150e9, 0.0};
  joint.divide = divide;
  return joint;
}

inline mesh::ScaleSpec scale(const std::string& axis, const std::string& carrier, const std::string& head_body,
                             const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& fixed_at,
                             const Eigen::Vector3d& head, double expansion) {
  mesh::ScaleSpec s;
  s.axis = axis;
  s.carrier = carrier;
  s.head_body = head_body;
  s.start = start;
  s.end = end;
  s.fixed_at = fixed_at;
  s.head = head;
  s.expansion = {expansion, 0.0};
  return s;
}

inline mesh::Machine box_machine(const BoxMachineOptions& options = {}) {
  mesh::Machine machine;
  machine.name = "boxes";
  machine.path = "boxes/machine.toml";
  machine.materials = {steel()};
  machine.bodies = {body("bed"), body("slide", "steel", "bed", "X"), body("table", "steel", "slide", "C"),
                    body("column", "steel", "bed"), body("head", "steel", "column", "Z")};
  machine.axes = {linear_axis("X", Eigen::Vector3d::UnitX(), -0.2, 0.2),
                  linear_axis("Z", Eigen::Vector3d::UnitZ(), -0.1, 0.1)};
  mesh::Axis turn;
  turn.id = "C";
  turn.kind = mesh::AxisKind::rotary;
  turn.direction = Eigen::Vector3d::UnitZ();
  turn.low = -3.2;
  turn.high = 3.2;
  turn.endless = true;
  turn.rapid = 10.0;
  machine.axes.push_back(turn);
  machine.surfaces = {surface("bed.feet", "bed", {"z0"}),          surface("bed.top", "bed", {"z1"}),
                      surface("slide.carriages", "slide", {"z0"}), surface("slide.top", "slide", {"z1"}),
                      surface("table.seat", "table", {"z0"}),      surface("table.top", "table", {"z1"}),
                      surface("column.foot", "column", {"z0"}),    surface("column.rails", "column", {"y0"}),
                      surface("head.carriages", "head", {"y1"}),   surface("head.nose", "head", {"z0"})};
  machine.joints = {elastic_joint("mounts", "mount", "bed.feet", "", "", {2, 2, 1}),
                    elastic_joint("X_guide", "guide", "slide.carriages", "bed.top", "X", {2, 2, 1}),
                    elastic_joint("C_bearing", "bearing", "table.seat", "slide.top", "C", {2, 2, 1}),
                    elastic_joint("column_foot", "bolted", "column.foot", "bed.top", "", {2, 2, 1}),
                    elastic_joint("Z_guide", "guide", "head.carriages", "column.rails", "Z", {2, 1, 2})};
  machine.joints[0].stiffness_normal = {options.mount_normal, 0.0};
  machine.joints[0].stiffness_tangential = {options.mount_tangential, 0.0};
  machine.scales = {scale("X", "bed", "slide", {-0.4, -0.38, -0.1}, {0.4, -0.38, -0.1}, {-0.4, -0.38, -0.1},
                          {0.0, -0.2, -0.05}, options.tape_expansion),
                    scale("Z", "column", "head", {0.2, 0.25, 0.1}, {0.2, 0.25, 0.6}, {0.2, 0.25, 0.6}, {0.1, 0.2, 0.4},
                          options.tape_expansion)};
  machine.ambients = {ambient("air", 20.0), ambient("foundation", 20.0)};
  machine.films = {constant_film("bed.top", {"bed.top"}, 8.0)};
  machine.tcp.tool_body = "head";
  machine.tcp.tool_surface = "head.nose";
  machine.tcp.tool_point = {0.0, 0.1, 0.2};
  machine.tcp.table_body = "table";
  machine.tcp.table_surface = "table.top";
  machine.tcp.table_point = {0.0, 0.0, 0.05};
  machine.tcp.table_radius = 0.15;
  machine.workspace.axes = {"X", "Z"};
  machine.workspace.positions = {{-0.2, 0.0, 0.2}, {-0.1, 0.0, 0.1}};
  return machine;
}

inline mesh::MachineMesh box_machine_mesh(const BoxMachineOptions& options = {}) {
  const auto box = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3i& cells) {
    return box_mesh(low, high, cells * options.finer);
  };
  return machine_mesh(
      box_machine(options),
      {box({-0.5, -0.4, -0.3}, {0.5, 0.4, -0.1}, {8, 6, 2}), box({-0.2, -0.2, -0.1}, {0.2, 0.2, 0.0}, {4, 4, 2}),
       box({-0.15, -0.15, 0.0}, {0.15, 0.15, 0.05}, {4, 4, 1}), box({-0.2, 0.25, -0.1}, {0.2, 0.4, 0.6}, {4, 2, 7}),
       box({-0.1, 0.0, 0.25}, {0.1, 0.25, 0.45}, {2, 3, 2})});
}

inline mesh::Pose box_pose(double x, double z, double c = 0.0) {
  mesh::Pose pose(3);
  pose << x, z, c;
  return pose;
}

/// A smooth temperature that differs everywhere, K above the reference; (size).
inline Eigen::VectorXd uneven_temperature(const mesh::MachineMesh& mesh, Eigen::Index size) {
  Eigen::VectorXd temperature = Eigen::VectorXd::Zero(size);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    for (Eigen::Index i = 0; i < mesh.bodies[b].nodes(); ++i) {
      const Eigen::Vector3d p = mesh.bodies[b].points.col(i);
      temperature[mesh.first_node[b] + i] =
          2.0 + 3.0 * p.x() - 4.0 * p.y() + 6.0 * p.z() * p.x() + std::sin(5.0 * p.z() + b);
    }
  }
  return temperature;
}

}  // namespace thermotwin::test
