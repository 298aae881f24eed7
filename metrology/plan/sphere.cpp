// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/sphere.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "core/error.h"
#include "core/minimum_norm.h"
#include "solver/elastic/outputs.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::metrology {

using core::InputError;
using Eigen::Index;
using Eigen::Vector3d;
using mesh::AxisKind;
using mesh::Pose;

Vector3d sphere_on_table(const mesh::Machine& machine, double radius, double azimuth, double height) {
  const auto [origin, direction] = solver::growth_axis(machine);
  const Vector3d& top = machine.tcp.table_point;
  const Vector3d centre = origin + direction * direction.dot(top - origin);
  const Vector3d from = std::abs(direction.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  const Vector3d e = (from - direction * direction.dot(from)).normalized(), f = direction.cross(e);
  return centre + radius * (std::cos(azimuth) * e + std::sin(azimuth) * f) + height * direction;
}

Vector3d sphere_at(const mesh::Machine& machine, const Pose& pose, const Vector3d& sphere_in_table) {
  return mesh::body_transform(machine, machine.body_index(machine.tcp.table_body), pose) * sphere_in_table;
}

Pose pose_on_sphere(const mesh::Machine& machine, const Pose& rotary, const Vector3d& sphere_in_table,
                    const std::string& place) {
  const auto apart = [&](const Pose& pose) {
    return Vector3d(solver::tcp_position(machine, pose) - sphere_at(machine, pose, sphere_in_table));
  };
  std::vector<Index> linear;
  for (Index i = 0; i < rotary.size(); ++i)
    if (machine.axes[i].kind == AxisKind::linear) linear.push_back(i);
  Pose pose = rotary;
  const Vector3d start = apart(pose);
  Eigen::MatrixXd ways(3, std::ssize(linear));
  for (Index k = 0; k < ways.cols(); ++k) {
    Pose moved = pose;
    moved[linear[k]] += 0.1;
    ways.col(k) = (apart(moved) - start) / 0.1;  // exact: linear axes move in a straight line
  }
  const Eigen::VectorXd by = core::minimum_norm_solution(ways, -start);
  for (Index k = 0; k < ways.cols(); ++k) pose[linear[k]] += by[k];
  if (const double left = apart(pose).norm(); left > 1e-9) {
    throw InputError(place, fmt::format("the linear axes leave the tool {:.4g} mm from the sphere", 1e3 * left),
                     "a machine whose linear axes move the tool against the table in three directions");
  }
  return pose;
}

mesh::KinematicChain chain_of(const mesh::Machine& machine) {
  const std::string place = machine.path.string() + " kinematic_chain";
  if (machine.kinematic_chain.empty())
    throw InputError(place, "absent", "a chain of ISO 10791-1 such as V [w C' B' b Y X Z (C1) t]");
  mesh::KinematicChain chain = mesh::KinematicChain::parse(machine.kinematic_chain, place);
  for (const mesh::Axis& axis : machine.axes) {
    mesh::ChainAxis* found = chain.find(axis.id);
    if (found == nullptr)
      throw InputError(place, "no axis " + axis.id, "a chain with all axes of the machine in their order");
    const double along = found->direction.dot(axis.direction);
    if (std::abs(std::abs(along) - 1.0) > 1e-9 || (along < 0 && !(found->rotary && found->table_side))) {
      throw InputError(place, "axis " + axis.id + " does not move its body in the sense of its letter",
                       "axes along X, Y and Z: the tool with its letter, a linear axis of the table against it");
    }
    found->direction = axis.direction;
    found->origin = axis.kind == AxisKind::rotary ? axis.origin : Vector3d::Zero();
  }
  return chain;
}

std::map<std::string, double> positions_of(const mesh::Machine& machine, const Pose& pose) {
  std::map<std::string, double> positions;
  for (Index i = 0; i < pose.size(); ++i) positions[machine.axes[i].id] = pose[i];
  return positions;
}

}  // namespace thermotwin::metrology
