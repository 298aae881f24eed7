// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/assembly.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>

#include "core/error.h"

namespace thermotwin::solver {
namespace {

struct Lame {
  double lambda, mu, thermal;  ///< Pa, Pa, Pa/K
};

Lame lame_of(const mesh::Material& material) {
  const double young = material.young, poisson = material.poisson;
  return {young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)),
          young * material.expansion.value / (1.0 - 2.0 * poisson)};
}

/// Farthest node from the first; farthest from the line through both.
std::array<Eigen::Index, 3> far_nodes(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& centre) {
  std::array<Eigen::Index, 3> node{};
  (points.colwise() - centre).colwise().squaredNorm().maxCoeff(&node[0]);
  const Eigen::Vector3d a = points.col(node[0]);
  (points.colwise() - a).colwise().squaredNorm().maxCoeff(&node[1]);
  const Eigen::Vector3d line = (points.col(node[1]) - a).normalized();
  double largest = -1.0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double distance = (points.col(i) - a).cross(line).squaredNorm();
    if (distance > largest) largest = distance, node[2] = i;
  }
  return node;
}

/// The six of the nine degrees of freedom of three nodes that hold the rigid motions best.
std::array<Eigen::Index, 6> choose_supports(const ElasticBody& body, const Eigen::Matrix3Xd& points,
                                            const std::string& name) {
  const auto nodes = far_nodes(points, body.centre);
  std::array<Eigen::Index, 9> candidates{};
  for (int i = 0; i < 9; ++i) candidates[i] = 3 * nodes[i / 3] + i % 3;
  double best = 1e-6;  // below it the three nodes lie on a line
  std::array<Eigen::Index, 6> chosen{};
  bool found = false;
  for (unsigned mask = 0; mask < 512; ++mask) {
    if (__builtin_popcount(mask) != 6) continue;
    Eigen::Matrix<double, 6, 6> held;
    std::array<Eigen::Index, 6> dofs{};
    int row = 0;
    for (unsigned i = 0; i < 9; ++i) {
      if (!(mask >> i & 1u)) continue;
      dofs[row] = candidates[i];
      held.row(row++) = body.rigid.row(candidates[i]);
    }
    const double smallest = Eigen::JacobiSVD<Eigen::Matrix<double, 6, 6>>(held).singularValues()[5];
    if (smallest > best) best = smallest, chosen = dofs, found = true;
  }
  if (!found) throw core::MeshError("body '" + name + "'", "all nodes lie on a line", "a body with a volume");
  return chosen;
}

}  // namespace

ElasticBody assemble_elastic(const mesh::TetMesh& mesh, const mesh::Material& material, const std::string& name) {
  const Eigen::Index nodes = mesh.nodes();
  ElasticBody body;

  double volume = 0.0;
  body.centre.setZero();
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const double part = mesh.volume(e);
    for (int a = 0; a < 4; ++a) body.centre += 0.25 * part * mesh.points.col(mesh.tets(a, e));
    volume += part;
  }
  body.centre /= volume;
  body.length = std::sqrt((mesh.points.colwise() - body.centre).colwise().squaredNorm().mean());
  body.rigid.setZero(3 * nodes, 6);
  for (Eigen::Index i = 0; i < nodes; ++i) {
    const Eigen::Vector3d arm = (mesh.points.col(i) - body.centre) / body.length;
    for (int j = 0; j < 3; ++j) {
      body.rigid(3 * i + j, j) = 1.0;
      body.rigid.block<3, 1>(3 * i, 3 + j) = Eigen::Vector3d::Unit(j).cross(arm);
    }
  }
  body.fixed = choose_supports(body, mesh.points, name);
  std::vector<char> is_fixed(3 * nodes, 0);
  for (Eigen::Index dof : body.fixed) is_fixed[dof] = 1;

  body.stiffness = elastic_stiffness(mesh, material);
  double diagonal = 0.0;
  for (Eigen::Index i = 0; i < 3 * nodes; ++i) diagonal += body.stiffness.coeff(i, i) / (3 * nodes);
  for (int column = 0; column < body.stiffness.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(body.stiffness, column); it; ++it)
      if (is_fixed[it.row()] || is_fixed[column]) it.valueRef() = it.row() == column ? diagonal : 0.0;
  }
  body.thermal_load = thermal_load(mesh, material);
  return body;
}

SparseMatrix elastic_stiffness(const mesh::TetMesh& mesh, const mesh::Material& material) {
  const Lame lame = lame_of(material);
  const std::vector<mesh::TetPoint>& rule = mesh::tet_rule(2 * (mesh.order() - 1));
  std::vector<mesh::TetSlopes> slopes;
  for (const mesh::TetPoint& point : rule) slopes.push_back(mesh::tet_slopes(mesh.order(), point.at));
  const Eigen::Index n = slopes.front().rows();
  ElementMatrix stiffness(mesh, 3, 3);
  Eigen::MatrixXd element(3 * n, 3 * n);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const Eigen::Matrix<double, 4, 3> to_space = mesh::barycentric_gradients(mesh, e);
    const double volume = mesh.volume(e);
    element.setZero();
    for (std::size_t p = 0; p < rule.size(); ++p) {
      const mesh::TetGradients g = slopes[p] * to_space;
      const double lambda = rule[p].share * volume * lame.lambda, mu = rule[p].share * volume * lame.mu;
      for (Eigen::Index a = 0; a < n; ++a) {
        for (Eigen::Index b = 0; b < n; ++b) {
          const Eigen::Vector3d ga = g.row(a), gb = g.row(b);
          auto block = element.block<3, 3>(3 * a, 3 * b);
          block.noalias() += lambda * ga * gb.transpose();
          block.noalias() += mu * gb * ga.transpose();
          block.diagonal().array() += mu * ga.dot(gb);
        }
      }
    }
    stiffness.add(mesh::tet_nodes(mesh, e), element);
  }
  return stiffness.take();
}

SparseMatrix thermal_load(const mesh::TetMesh& mesh, const mesh::Material& material) {
  const Lame lame = lame_of(material);
  // Integral of dN_a/dL_k N_b over an element of volume 1.
  const Eigen::Index n = mesh.order() == 1 ? 4 : 10;
  std::array<Eigen::MatrixXd, 4> integral;
  integral.fill(Eigen::MatrixXd::Zero(n, n));
  for (const mesh::TetPoint& point : mesh::tet_rule(2 * mesh.order() - 1)) {
    const mesh::TetSlopes slopes = mesh::tet_slopes(mesh.order(), point.at);
    const mesh::TetValues values = mesh::tet_shape(mesh.order(), point.at);
    for (int k = 0; k < 4; ++k) integral[k] += point.share * slopes.col(k) * values.transpose();
  }
  ElementMatrix load(mesh, 3, 1);
  Eigen::MatrixXd element(3 * n, n);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const Eigen::Matrix<double, 4, 3> to_space = mesh.volume(e) * lame.thermal * mesh::barycentric_gradients(mesh, e);
    element.setZero();
    for (int k = 0; k < 4; ++k) {
      for (Eigen::Index a = 0; a < n; ++a)
        element.middleRows<3>(3 * a) += to_space.row(k).transpose() * integral[k].row(a);
    }
    load.add(mesh::tet_nodes(mesh, e), element);
  }
  return load.take();
}

void clear_fixed(const ElasticBody& body, Eigen::MatrixXd& loads) {
  for (Eigen::Index dof : body.fixed) loads.row(dof).setZero();
}

Vector6 stress_at(const mesh::TetMesh& mesh, const mesh::Material& material, const Eigen::VectorXd& displacement,
                  const Eigen::VectorXd& temperature, Eigen::Index element, const Eigen::Vector4d& at) {
  const Lame lame = lame_of(material);
  const mesh::TetNodes nodes = mesh::tet_nodes(mesh, element);
  const mesh::TetGradients slopes = mesh::tet_slopes(mesh.order(), at) * mesh::barycentric_gradients(mesh, element);
  const mesh::TetValues values = mesh::tet_shape(mesh.order(), at);
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  double warm = 0.0;
  for (Eigen::Index a = 0; a < nodes.size(); ++a) {
    gradient += displacement.segment<3>(3 * nodes[a]) * slopes.row(a);
    warm += values[a] * temperature[nodes[a]];
  }
  const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
  const Eigen::Matrix3d s =
      2.0 * lame.mu * strain + (lame.lambda * strain.trace() - lame.thermal * warm) * Eigen::Matrix3d::Identity();
  Vector6 stress;
  stress << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0);
  return stress;
}

}  // namespace thermotwin::solver
