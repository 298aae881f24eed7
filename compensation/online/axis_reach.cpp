// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/axis_reach.h"

#include <Eigen/SVD>
#include <fmt/format.h>

#include <algorithm>

namespace thermotwin::compensation {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

/// Motion of a body by a unit of the axis, in the machine frame at the pose; nought: the axis does not carry it.
Vector3d motion_of(const mesh::Machine& machine, int body, const mesh::Axis& axis, const mesh::Pose& pose) {
  for (; body >= 0; body = machine.body_index(machine.bodies[body].parent)) {
    if (machine.bodies[body].axis == axis.id)
      return mesh::body_transform(machine, machine.body_index(machine.bodies[body].parent), pose).linear() *
             axis.direction;
  }
  return Vector3d::Zero();
}

/// @param unmoved  the projector to the directions
std::string words_of(const Matrix3d& unmoved, Eigen::Index count) {
  constexpr const char* names[] = {"x (dx)", "y (dy)", "z (dz)"};
  std::string words;
  Eigen::Index named = 0, left = count;
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (unmoved(k, k) < 1.0 - 1e-9) continue;
    ++named;
    words += std::string(named == 1 ? "" : --left == 1 ? " and " : ", ") + names[k];
  }
  if (named == count) return words;
  // Oblique: the direction itself, or the one that is moved.
  const Matrix3d shown = count == 1 ? unmoved : Matrix3d(Matrix3d::Identity() - unmoved);
  Eigen::Index longest = 0;
  shown.diagonal().maxCoeff(&longest);
  const Vector3d direction = shown.col(longest).normalized();
  return fmt::format("{}({:.2f}, {:.2f}, {:.2f})", count == 1 ? "" : "what is normal to ", direction.x(), direction.y(),
                     direction.z());
}

}  // namespace

AxisReach::AxisReach(const mesh::Machine& machine, const mesh::Pose& pose)
    : motions_(3, 0),
      unmoved_(Matrix3d::Zero()) {
  const int tool = machine.body_index(machine.tcp.tool_body), table = machine.body_index(machine.tcp.table_body);
  for (const mesh::Axis& axis : machine.axes) {
    if (axis.kind != mesh::AxisKind::linear) continue;
    motions_.conservativeResize(Eigen::NoChange, motions_.cols() + 1);
    motions_.rightCols(1) = motion_of(machine, tool, axis, pose) - motion_of(machine, table, axis, pose);
  }
  Eigen::Index moved = 0;
  Matrix3d reach = Matrix3d::Zero();
  if (motions_.cols() > 0) {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(motions_), Eigen::ComputeFullU);
    while (moved < svd.singularValues().size() && svd.singularValues()[moved] > 1e-6) ++moved;
    const Matrix3Xd directions = svd.matrixU().leftCols(moved);
    reach = directions * directions.transpose();
  }
  if (moved == 3) return;
  unmoved_ = Matrix3d::Identity() - reach;
  words_ = words_of(unmoved_, 3 - moved);
}

}  // namespace thermotwin::compensation
