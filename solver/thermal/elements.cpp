// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/elements.h"

#include <Eigen/Dense>

#include <limits>

#include "mesh/body/triangle_tree.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using mesh::TetMesh;

namespace {

constexpr double outside = 1e-9;  // barycentric: rounding that still counts as inside

/// Integral of N N^T over an element of volume 1.
MatrixXd tet_mass(int order, ElementRules rules) {
  if (order == 1 && rules == ElementRules::reduced) return MatrixXd::Constant(4, 4, 1.0 / 16.0);
  MatrixXd mass = MatrixXd::Zero(order == 1 ? 4 : 10, order == 1 ? 4 : 10);
  for (const mesh::TetPoint& point : mesh::tet_rule(rules == ElementRules::reduced ? 2 : 2 * order)) {
    const mesh::TetValues n = mesh::tet_shape(order, point.at);
    mass += point.share * n * n.transpose();
  }
  return mass;
}

MatrixXd make_face_mass(int order, int degree) {
  MatrixXd mass = MatrixXd::Zero(3 * order, 3 * order);
  for (const mesh::FacePoint& point : mesh::face_rule(degree)) {
    const mesh::FaceValues n = mesh::face_shape(order, point.at);
    mass += point.share * n * n.transpose();
  }
  return mass;
}

SparseMatrix lumped_capacity(const TetMesh& body, const Eigen::VectorXd& shares, double per_volume) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(body.nodes());
  for (Index e = 0; e < body.elements(); ++e) {
    const mesh::TetNodes nodes = mesh::tet_nodes(body, e);
    const double heat = per_volume * body.volume(e);
    for (Index i = 0; i < nodes.size(); ++i) diagonal[nodes[i]] += heat * shares[i];
  }
  SparseMatrix capacity(body.nodes(), body.nodes());
  capacity.reserve(Eigen::VectorXi::Ones(body.nodes()));
  for (Index i = 0; i < body.nodes(); ++i) capacity.insert(i, i) = diagonal[i];
  capacity.makeCompressed();
  return capacity;
}

/// Every second row of a matrix whose rows have as many entries in pairs.
SparseMatrix one_of_two(const SparseMatrix& stacked, Index which) {
  SparseMatrix matrix(stacked.cols(), stacked.cols());
  matrix.resizeNonZeros(stacked.nonZeros() / 2);
  for (Index column = 0; column <= stacked.cols(); ++column)
    matrix.outerIndexPtr()[column] = stacked.outerIndexPtr()[column] / 2;
  for (Index i = 0; i < matrix.nonZeros(); ++i) {
    matrix.innerIndexPtr()[i] = stacked.innerIndexPtr()[2 * i + which] / 2;
    matrix.valuePtr()[i] = stacked.valuePtr()[2 * i + which];
  }
  return matrix;
}

}  // namespace

BodyHeat assemble_heat(const TetMesh& body, const mesh::Material& material, bool lumped, ElementRules rules) {
  const int order = body.order();
  const double per_volume = material.density * material.specific_heat.value;
  const Eigen::Matrix3d tensor =
      material.conductivity_tensor.value_or(material.conductivity * Eigen::Matrix3d::Identity());
  const MatrixXd mass = tet_mass(order, rules);
  struct Slopes {
    mesh::TetSlopes at;
    double share;
  };
  std::vector<Slopes> slopes;
  for (const mesh::TetPoint& point : mesh::tet_rule(2 * (order - 1)))
    slopes.push_back({mesh::tet_slopes(order, point.at), point.share});

  // Both matrices have one pattern: summed up as one whose nodes have a row of each.
  const int sets = lumped ? 1 : 2;
  ElementMatrix sum(body, sets, 1);
  const Index n = mass.rows();
  MatrixXd k(n, n), both(sets * n, n);
  for (Index e = 0; e < body.elements(); ++e) {
    const double volume = body.volume(e);
    const Eigen::Matrix<double, 4, 3> gradients = mesh::barycentric_gradients(body, e);
    const Eigen::Matrix4d g = volume * gradients * tensor * gradients.transpose();
    k.setZero();
    for (const Slopes& s : slopes) k += s.share * s.at * g * s.at.transpose();
    for (Index j = 0; j < n; ++j) {
      for (Index i = 0; i < n; ++i) {
        both(sets * i, j) = k(i, j);
        if (!lumped) both(2 * i + 1, j) = per_volume * volume * mass(i, j);
      }
    }
    sum.add(mesh::tet_nodes(body, e), both);
  }
  const SparseMatrix stacked = sum.take();
  return {lumped ? lumped_capacity(body, mass.diagonal() / mass.trace(), per_volume) : one_of_two(stacked, 1),
          lumped ? stacked : one_of_two(stacked, 0)};
}

const MatrixXd& face_mass(int order, ElementRules rules) {
  static const MatrixXd exact[2] = {make_face_mass(1, 2), make_face_mass(2, 4)};
  static const MatrixXd reduced[2] = {MatrixXd::Constant(3, 3, 1.0 / 9.0), make_face_mass(2, 2)};
  return (rules == ElementRules::reduced ? reduced : exact)[order - 1];
}

mesh::FaceValues face_load(int order) {
  mesh::FaceValues load = mesh::FaceValues::Zero(3 * order);
  load.tail<3>().setConstant(1.0 / 3.0);  // quadratic: the corners' functions have no mean
  return load;
}

SparseColumn interpolation_at(const TetMesh& body, const Vector3d& p) {
  SparseColumn weights;
  for (Index e = 0; e < body.elements(); ++e) {
    const Vector3d a = body.points.col(body.tets(0, e));
    double reach = 0.0;
    for (int i = 1; i < 4; ++i) reach = std::max(reach, (body.points.col(body.tets(i, e)) - a).cwiseAbs().maxCoeff());
    if ((p - a).cwiseAbs().maxCoeff() > reach) continue;
    const Eigen::Vector4d at = mesh::barycentric(body, e, p);
    if (at.minCoeff() < -outside) continue;
    const mesh::TetNodes nodes = mesh::tet_nodes(body, e);
    const mesh::TetValues values = mesh::tet_shape(body.order(), at);
    for (Index i = 0; i < nodes.size(); ++i) weights.emplace_back(nodes[i], values[i]);
    return weights;
  }
  double best = std::numeric_limits<double>::infinity();
  Index nearest = 0;
  Vector3d on = p;
  for (Index f = 0; f < body.face_count(); ++f) {
    const Vector3d q = mesh::nearest_on_triangle(p, body.points.col(body.faces(0, f)),
                                                 body.points.col(body.faces(1, f)), body.points.col(body.faces(2, f)));
    if ((q - p).norm() < best) best = (q - p).norm(), nearest = f, on = q;
  }
  Vector3d at = mesh::face_barycentric(body, nearest, on).cwiseMax(0.0);
  at /= at.sum();
  const mesh::FaceNodes nodes = mesh::face_nodes(body, nearest);
  const mesh::FaceValues values = mesh::face_shape(body.order(), at);
  for (Index i = 0; i < nodes.size(); ++i) weights.emplace_back(nodes[i], values[i]);
  return weights;
}

}  // namespace thermotwin::solver
