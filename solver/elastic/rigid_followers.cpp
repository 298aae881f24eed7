// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/rigid_followers.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <set>

#include "mesh/body/triangle_tree.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::solver {

std::vector<CarriedBody> carried_bodies(const mesh::MachineMesh& mesh) {
  const mesh::Machine& machine = mesh.machine;
  std::vector<CarriedBody> carried;
  for (std::size_t b = 0; b < machine.bodies.size(); ++b) {
    if (machine.bodies[b].elastic) continue;
    CarriedBody body;
    body.body = b;
    body.first_node = mesh.first_node[b];
    body.points = mesh.bodies[b].points;
    std::string parent = machine.bodies[b].parent;
    while (!parent.empty() && !machine.bodies[machine.body_index(parent)].elastic)
      parent = machine.bodies[machine.body_index(parent)].parent;
    if (!parent.empty()) {
      body.parent = machine.body_index(parent);
      const mesh::TetMesh& carrier = mesh.bodies[body.parent];
      body.parent_first = mesh.first_node[body.parent];
      const mesh::TriangleTree skin(carrier.points, carrier.faces);
      std::set<Eigen::Index> nodes;
      for (Eigen::Index i = 0; i < body.points.cols(); ++i) {
        const int triangle = skin.nearest(body.points.col(i)).triangle;
        for (int k = 0; k < 3; ++k) nodes.insert(carrier.faces(k, triangle));
      }
      body.neighbours.assign(nodes.begin(), nodes.end());
      body.neighbour_points.resize(3, std::ssize(nodes));
      for (std::size_t i = 0; i < body.neighbours.size(); ++i)
        body.neighbour_points.col(i) = carrier.points.col(body.neighbours[i]);
    }
    carried.push_back(std::move(body));
  }
  return carried;
}

void move_with_parent(const CarriedBody& body, const mesh::Machine& machine, const mesh::Pose& pose,
                      Eigen::Matrix3Xd& displacement) {
  if (body.parent < 0) return;
  const Eigen::Vector3d centre = body.neighbour_points.rowwise().mean();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < body.neighbours.size(); ++i) {
    const Eigen::Vector3d r = body.neighbour_points.col(i) - centre;
    const Eigen::Vector3d u = displacement.col(body.parent_first + body.neighbours[i]);
    mean += u;
    moment += r.cross(u);
    inertia += r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose();
  }
  mean /= std::ssize(body.neighbours);
  const Eigen::Vector3d rotation = inertia.ldlt().solve(moment);
  const Eigen::Matrix3d turn = mesh::body_transform(machine, body.body, pose).linear().transpose() *
                               mesh::body_transform(machine, body.parent, pose).linear();
  for (Eigen::Index i = 0; i < body.points.cols(); ++i)
    displacement.col(body.first_node + i) = turn * (mean + rotation.cross(body.points.col(i) - centre));
}

}  // namespace thermotwin::solver
