// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/stress.h"

#include <cmath>

#include "core/thread_pool.h"
#include "solver/linear/sparse_factor.h"

namespace thermotwin::solver {

using Eigen::Index;

StressRecovery::StressRecovery(const mesh::TetMesh& mesh) : mesh_(mesh), corner_(mesh.nodes(), -1) {
  for (Index e = 0; e < mesh.elements(); ++e)
    for (const int node : mesh.tets.col(e)) corner_[node] = 0;
  int corners = 0;
  for (int& number : corner_)
    if (number == 0) number = corners++;
  mesh::TetMesh linear;  // numbered by corners alone
  linear.points.resize(3, corners);
  linear.tets = mesh.tets.unaryExpr([&](int node) { return corner_[node]; });
  ElementMatrix mass(linear);
  const Eigen::Matrix4d shares = (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity()) / 20.0;
  for (Index e = 0; e < mesh.elements(); ++e) mass.add(mesh::tet_nodes(linear, e), mesh.volume(e) * shares);
  mass_ = std::make_unique<SparseFactor>(mass.take());
}

StressRecovery::~StressRecovery() = default;
StressRecovery::StressRecovery(StressRecovery&&) noexcept = default;

Eigen::MatrixXd StressRecovery::nodal(const mesh::Material& material, const Eigen::VectorXd& displacement,
                                      const Eigen::VectorXd& temperature) const {
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(mass_->size(), 6);
  const std::vector<mesh::TetPoint>& rule = mesh::tet_rule(mesh_.order() + 1);
  for (Index e = 0; e < mesh_.elements(); ++e) {
    for (const mesh::TetPoint& point : rule) {
      const Vector6 stress = stress_at(mesh_, material, displacement, temperature, e, point.at);
      const double weight = mesh_.volume(e) * point.share;
      for (int i = 0; i < 4; ++i) load.row(corner_[mesh_.tets(i, e)]) += weight * point.at[i] * stress.transpose();
    }
  }
  const Eigen::MatrixXd at_corners = mass_->solve(load);
  Eigen::MatrixXd stress(6, mesh_.nodes());
  for (Index node = 0; node < mesh_.nodes(); ++node)
    if (const int corner = corner_[node]; corner >= 0) stress.col(node) = at_corners.row(corner).transpose();
  for (Index e = 0; mesh_.order() == 2 && e < mesh_.elements(); ++e) {
    for (int i = 0; i < 6; ++i) {
      stress.col(mesh_.tet_edges(i, e)) =
          0.5 * (stress.col(mesh_.tets(mesh::tet_edge[i][0], e)) + stress.col(mesh_.tets(mesh::tet_edge[i][1], e)));
    }
  }
  return stress;
}

Vector6 turned(const Vector6& s, const Eigen::Matrix3d& turn) {
  Eigen::Matrix3d own;
  own << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  const Eigen::Matrix3d t = turn * own * turn.transpose();
  return (Vector6() << t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(1, 2), t(2, 0)).finished();
}

Eigen::VectorXd von_mises(const Eigen::MatrixXd& stress) {
  Eigen::VectorXd equivalent(stress.cols());
  for (Index i = 0; i < stress.cols(); ++i) {
    const auto s = stress.col(i);
    const double a = s[0] - s[1], b = s[1] - s[2], c = s[2] - s[0];
    equivalent[i] = std::sqrt(0.5 * (a * a + b * b + c * c) + 3.0 * s.tail<3>().squaredNorm());
  }
  return equivalent;
}

MachineStress::MachineStress(const mesh::MachineMesh& mesh) : mesh_(mesh), bodies_(mesh.bodies.size()) {
  core::parallel_for(0, bodies_.size(), [&](std::size_t b) {
    if (mesh.machine.bodies[b].elastic) bodies_[b] = std::make_unique<StressRecovery>(mesh.bodies[b]);
  });
}

Eigen::MatrixXd MachineStress::nodal(const Eigen::Matrix3Xd& displacement, const Eigen::VectorXd& temperature) const {
  Eigen::MatrixXd stress = Eigen::MatrixXd::Zero(6, mesh_.nodes());
  core::parallel_for(0, bodies_.size(), [&](std::size_t b) {
    if (!bodies_[b]) return;
    const Index first = mesh_.first_node[b], count = mesh_.bodies[b].nodes();
    const Eigen::VectorXd motion = Eigen::Map<const Eigen::VectorXd>(displacement.data() + 3 * first, 3 * count);
    stress.middleCols(first, count) = bodies_[b]->nodal(mesh_.machine.material(mesh_.machine.bodies[b].material),
                                                        motion, temperature.segment(first, count));
  });
  return stress;
}

}  // namespace thermotwin::solver
