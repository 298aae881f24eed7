// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/tcp_kinematics.h"

#include <Eigen/LU>

#include <algorithm>

#include "core/error.h"

namespace thermotwin::nc {

TcpKinematics::TcpKinematics(const mesh::Machine& machine) {
  if (!machine.has_tcp())
    throw core::InputError(machine.path.string(), "tool centre point control without [tcp]",
                           "a machine.toml with [tcp]");
  tool_ = chain_to(machine, machine.body_index(machine.tcp.tool_body));
  table_ = chain_to(machine, machine.body_index(machine.tcp.table_body));
  gauge_ = machine.tcp.tool_point;
  column_.assign(machine.axes.size(), -1);
  for (const auto* chain : {&tool_, &table_}) {
    for (const Link& link : *chain) {
      if (!link.linear || column_[link.axis] >= 0) continue;
      column_[link.axis] = linear_.size();
      linear_.push_back(link.axis);
    }
  }
  if (linear_.size() != 3)
    throw core::InputError(machine.path.string(),
                           std::to_string(linear_.size()) + " linear axes between workpiece and tool",
                           "three, for tool centre point control");
}

std::vector<TcpKinematics::Link> TcpKinematics::chain_to(const mesh::Machine& machine, int body) {
  std::vector<Link> chain;
  while (body >= 0) {
    const mesh::BodySpec& spec = machine.bodies[body];
    if (const int a = spec.axis.empty() ? -1 : machine.axis_index(spec.axis); a >= 0) {
      const mesh::Axis& axis = machine.axes[a];
      chain.push_back({a, axis.kind == mesh::AxisKind::linear, axis.direction, axis.origin});
    }
    body = spec.parent.empty() ? -1 : machine.body_index(spec.parent);
  }
  std::reverse(chain.begin(), chain.end());
  return chain;
}

Eigen::Isometry3d TcpKinematics::frame(const std::vector<Link>& chain, const Positions& positions, bool linear) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  for (const Link& link : chain) {
    if (link.linear) {
      if (linear) result.translate(positions[link.axis] * link.direction);
    } else {
      result.translate(link.origin)
          .rotate(Eigen::AngleAxisd(positions[link.axis], link.direction))
          .translate(-link.origin);
    }
  }
  return result;
}

void TcpKinematics::motions(const std::vector<Link>& chain, const Positions& positions, double sign,
                            const std::vector<int>& column, Eigen::Matrix3d& out) {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  for (const Link& link : chain) {
    if (link.linear)
      out.col(column[link.axis]) += sign * (turned * link.direction);
    else
      turned = turned * Eigen::AngleAxisd(positions[link.axis], link.direction).toRotationMatrix();
  }
}

void TcpKinematics::solve(const Eigen::Vector3d& point, const Eigen::Vector3d& tool, Positions& positions) const {
  Eigen::Matrix3d motion = Eigen::Matrix3d::Zero();
  motions(tool_, positions, 1.0, column_, motion);
  motions(table_, positions, -1.0, column_, motion);
  const Eigen::Vector3d apart =
      frame(table_, positions, false) * (gauge_ + point) - frame(tool_, positions, false) * (gauge_ - tool);
  const Eigen::Vector3d q = motion.inverse() * apart;
  for (int i = 0; i < 3; ++i) positions[linear_[i]] = q[i];
}

Eigen::Vector3d TcpKinematics::point(const Positions& positions, const Eigen::Vector3d& tool) const {
  return frame(table_, positions, true).inverse() * (frame(tool_, positions, true) * (gauge_ - tool)) - gauge_;
}

}  // namespace thermotwin::nc
