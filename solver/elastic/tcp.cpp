// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/tcp.h"

#include <Eigen/Geometry>

#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/elastic/outputs.h"

namespace thermotwin::solver {
namespace {

using Eigen::Vector3d;

Vector6 turned(const Eigen::Isometry3d& frame, const Vector3d& translation, const Vector3d& rotation) {
  Vector6 motion;
  motion.head<3>() = frame.linear() * translation;
  motion.tail<3>() = frame.linear() * rotation;
  return motion;
}

}  // namespace

Vector3d tcp_position(const mesh::Machine& machine, const mesh::Pose& pose) {
  return mesh::body_transform(machine, machine.body_index(machine.tcp.tool_body), pose) * machine.tcp.tool_point;
}

TcpError tcp_error(const mesh::Machine& machine, const mesh::Pose& pose, const Vector6& tool, const Vector6& table_axis,
                   const Vector7& table_own) {
  const mesh::TcpSpec& tcp = machine.tcp;
  const TableFrames frames = table_frames(machine);
  const Vector3d tcp_in_machine = tcp_position(machine, pose);

  const Eigen::Isometry3d carrier = mesh::body_transform(machine, frames.carrier, pose);
  const Vector3d arm_in_carrier = carrier.inverse() * tcp_in_machine - tcp.table_point;
  const Vector3d axis_rotation = table_axis.tail<3>();
  const Vector6 axis_part = turned(carrier, table_axis.head<3>() + axis_rotation.cross(arm_in_carrier), axis_rotation);

  const Eigen::Isometry3d table = mesh::body_transform(machine, frames.table, pose);
  const Vector3d tcp_in_table = table.inverse() * tcp_in_machine;
  const Vector3d own_rotation = table_own.segment<3>(3);
  Vector3d own = table_own.head<3>() + own_rotation.cross(tcp_in_table - tcp.table_point);
  if (tcp.table_radius > 0.0) {
    const auto [origin, direction] = growth_axis(machine);
    const Vector3d from_axis = tcp_in_table - origin;
    own += table_own[6] / tcp.table_radius * (from_axis - from_axis.dot(direction) * direction);
  }

  TcpError result;
  result.tool = tool;
  result.table = axis_part + turned(table, own, own_rotation);
  result.error = result.tool - result.table;
  return result;
}

std::vector<std::string> tcp_columns() {
  std::vector<std::string> columns;
  for (const char* side : {"", "_tool", "_table"}) {
    for (const char* name : {"dx", "dy", "dz"}) columns.push_back(name + std::string("_um") + side);
    for (const char* name : {"ra", "rb", "rc"}) columns.push_back(name + std::string("_um_per_m") + side);
  }
  return columns;
}

Eigen::VectorXd tcp_values(const TcpError& error) {
  Eigen::VectorXd values(18);
  int at = 0;
  for (const Vector6* part : {&error.error, &error.tool, &error.table}) {
    values.segment<3>(at) = part->head<3>() / core::units::um;
    values.segment<3>(at + 3) = part->tail<3>() / core::units::um_per_m;
    at += 6;
  }
  return values;
}

}  // namespace thermotwin::solver
