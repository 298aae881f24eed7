// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic_assembly.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "core/error.h"

namespace thermotwin::solver {
namespace {

/// Gradients of the four shape functions (columns), 1/m, and the volume, m^3.
struct Shape {
  Eigen::Matrix<double, 3, 4> gradient;
  double volume;
};

Shape shape_of(const mesh::TetMesh& mesh, Eigen::Index element) {
  const auto tet = mesh.tets.col(element);
  Eigen::Matrix3d edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = mesh.points.col(tet[i + 1]) - mesh.points.col(tet[0]);
  Shape shape;
  shape.volume = edges.determinant() / 6.0;
  const Eigen::Matrix3d inverse = edges.inverse();
  for (int i = 0; i < 3; ++i) shape.gradient.col(i + 1) = inverse.row(i).transpose();
  shape.gradient.col(0) = -inverse.colwise().sum().transpose();
  return shape;
}

struct Lame {
  double lambda, mu, thermal;  ///< Pa, Pa, Pa/K
};

Lame lame_of(const mesh::Material& material) {
  const double young = material.young, poisson = material.poisson;
  return {young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
          young / (2.0 * (1.0 + poisson)),
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
  for (int i = 0; i < 9; ++i) candidates[static_cast<std::size_t>(i)] = 3 * nodes[static_cast<std::size_t>(i / 3)] + i % 3;
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
      dofs[static_cast<std::size_t>(row)] = candidates[i];
      held.row(row++) = body.rigid.row(candidates[i]);
    }
    const double smallest = Eigen::JacobiSVD<Eigen::Matrix<double, 6, 6>>(held).singularValues()[5];
    if (smallest > best) best = smallest, chosen = dofs, found = true;
  }
  if (!found) throw core::MeshError("body '" + name + "'", "all nodes lie on a line", "a body with a volume");
  return chosen;
}

}  // namespace

ElasticBody assemble_elastic(const mesh::TetMesh& mesh, const mesh::Material& material,
                             const std::string& name) {
  const Lame lame = lame_of(material);
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
  std::vector<char> is_fixed(static_cast<std::size_t>(3 * nodes), 0);
  for (Eigen::Index dof : body.fixed) is_fixed[static_cast<std::size_t>(dof)] = 1;

  std::vector<Eigen::Triplet<double>> stiffness, load;
  stiffness.reserve(static_cast<std::size_t>(144 * mesh.elements()));
  load.reserve(static_cast<std::size_t>(48 * mesh.elements()));
  double diagonal = 0.0;
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const Shape shape = shape_of(mesh, e);
    const auto tet = mesh.tets.col(e);
    for (int a = 0; a < 4; ++a) {
      const Eigen::Vector3d ga = shape.gradient.col(a);
      const Eigen::Vector3d force = shape.volume * lame.thermal * 0.25 * ga;
      for (int b = 0; b < 4; ++b) {
        for (int i = 0; i < 3; ++i) load.emplace_back(3 * tet[a] + i, tet[b], force[i]);
        const Eigen::Vector3d gb = shape.gradient.col(b);
        const Eigen::Matrix3d block =
            shape.volume * (lame.lambda * ga * gb.transpose() + lame.mu * gb * ga.transpose() +
                            lame.mu * ga.dot(gb) * Eigen::Matrix3d::Identity());
        if (a == b) diagonal += block.trace();
        for (int i = 0; i < 3; ++i) {
          const Eigen::Index row = 3 * tet[a] + i;
          if (is_fixed[static_cast<std::size_t>(row)]) continue;
          for (int j = 0; j < 3; ++j) {
            const Eigen::Index column = 3 * tet[b] + j;
            if (!is_fixed[static_cast<std::size_t>(column)]) stiffness.emplace_back(row, column, block(i, j));
          }
        }
      }
    }
  }
  diagonal /= static_cast<double>(3 * nodes);
  for (Eigen::Index dof : body.fixed) stiffness.emplace_back(dof, dof, diagonal);
  body.stiffness.resize(3 * nodes, 3 * nodes);
  body.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  body.thermal_load.resize(3 * nodes, nodes);
  body.thermal_load.setFromTriplets(load.begin(), load.end());
  return body;
}

void clear_fixed(const ElasticBody& body, Eigen::MatrixXd& loads) {
  for (Eigen::Index dof : body.fixed) loads.row(dof).setZero();
}

Eigen::MatrixXd element_stress(const mesh::TetMesh& mesh, const mesh::Material& material,
                               const Eigen::VectorXd& displacement,
                               const Eigen::VectorXd& temperature) {
  const Lame lame = lame_of(material);
  Eigen::MatrixXd stress(6, mesh.elements());
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const Shape shape = shape_of(mesh, e);
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    double mean = 0.0;
    for (int a = 0; a < 4; ++a) {
      const Eigen::Index node = mesh.tets(a, e);
      gradient += displacement.segment<3>(3 * node) * shape.gradient.col(a).transpose();
      mean += 0.25 * temperature[node];
    }
    const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
    const Eigen::Matrix3d s = 2.0 * lame.mu * strain +
        (lame.lambda * strain.trace() - lame.thermal * mean) * Eigen::Matrix3d::Identity();
    stress.col(e) << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0);
  }
  return stress;
}

}  // namespace thermotwin::solver
