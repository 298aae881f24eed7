// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body/shape.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace thermotwin::mesh {

namespace {

/// Adds the point and all others that a permutation of its coordinates gives.
template <class Point, class Coordinates>
void add_orbit(std::vector<Point>& rule, Coordinates at, double share) {
  std::sort(at.begin(), at.end());
  do rule.push_back({at, share});
  while (std::next_permutation(at.begin(), at.end()));
}

std::vector<TetPoint> make_tet_rule(int degree) {
  std::vector<TetPoint> rule;
  if (degree <= 1) return {{Eigen::Vector4d::Constant(0.25), 1.0}};
  if (degree <= 2) {
    const double a = (5.0 - std::sqrt(5.0)) / 20.0;
    add_orbit(rule, Eigen::Vector4d(a, a, a, 1 - 3 * a), 0.25);
    return rule;
  }
  for (const auto& [a, share] : {std::pair{0.31088591926330060980, 0.11268792571801585080},
                                 std::pair{0.092735250310891226402, 0.073493043116361949544}})
    add_orbit(rule, Eigen::Vector4d(a, a, a, 1 - 3 * a), share);
  const double b = 0.045503704125649649492;
  add_orbit(rule, Eigen::Vector4d(b, b, 0.5 - b, 0.5 - b), 0.042546020777081466438);
  return rule;
}

std::vector<FacePoint> make_face_rule(int degree) {
  std::vector<FacePoint> rule;
  if (degree <= 1) return {{Eigen::Vector3d::Constant(1.0 / 3.0), 1.0}};
  if (degree <= 2) {
    add_orbit(rule, Eigen::Vector3d(1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0), 1.0 / 3.0);
    return rule;
  }
  const double root = std::sqrt(15.0);
  rule.push_back({Eigen::Vector3d::Constant(1.0 / 3.0), 9.0 / 40.0});
  for (const double sign : {-1.0, 1.0}) {
    const double a = (6.0 + sign * root) / 21.0;
    add_orbit(rule, Eigen::Vector3d(a, a, 1 - 2 * a), (155.0 + sign * root) / 1200.0);
  }
  return rule;
}

}  // namespace

TetNodes tet_nodes(const TetMesh& mesh, Eigen::Index element) {
  TetNodes nodes(mesh.order() == 2 ? 10 : 4);
  nodes.head<4>() = mesh.tets.col(element);
  if (mesh.order() == 2) nodes.tail<6>() = mesh.tet_edges.col(element);
  return nodes;
}

FaceNodes face_nodes(const TetMesh& mesh, Eigen::Index face) {
  const bool quadratic = mesh.face_edges.cols() > 0;
  FaceNodes nodes(quadratic ? 6 : 3);
  nodes.head<3>() = mesh.faces.col(face);
  if (quadratic) nodes.tail<3>() = mesh.face_edges.col(face);
  return nodes;
}

TetValues tet_shape(int order, const Eigen::Vector4d& at) {
  if (order == 1) return at;
  TetValues values(10);
  for (int i = 0; i < 4; ++i) values[i] = at[i] * (2.0 * at[i] - 1.0);
  for (int i = 0; i < 6; ++i) values[4 + i] = 4.0 * at[tet_edge[i][0]] * at[tet_edge[i][1]];
  return values;
}

FaceValues face_shape(int order, const Eigen::Vector3d& at) {
  if (order == 1) return at;
  FaceValues values(6);
  for (int i = 0; i < 3; ++i) values[i] = at[i] * (2.0 * at[i] - 1.0);
  for (int i = 0; i < 3; ++i) values[3 + i] = 4.0 * at[face_edge[i][0]] * at[face_edge[i][1]];
  return values;
}

TetSlopes tet_slopes(int order, const Eigen::Vector4d& at) {
  TetSlopes slopes = TetSlopes::Zero(order == 1 ? 4 : 10, 4);
  if (order == 1) {
    slopes.setIdentity();
    return slopes;
  }
  for (int i = 0; i < 4; ++i) slopes(i, i) = 4.0 * at[i] - 1.0;
  for (int i = 0; i < 6; ++i) {
    slopes(4 + i, tet_edge[i][0]) = 4.0 * at[tet_edge[i][1]];
    slopes(4 + i, tet_edge[i][1]) = 4.0 * at[tet_edge[i][0]];
  }
  return slopes;
}

Eigen::Matrix<double, 4, 3> barycentric_gradients(const TetMesh& mesh, Eigen::Index element) {
  Eigen::Matrix3d edges;
  for (int i = 0; i < 3; ++i)
    edges.col(i) = mesh.points.col(mesh.tets(i + 1, element)) - mesh.points.col(mesh.tets(0, element));
  Eigen::Matrix<double, 4, 3> gradients;
  gradients.bottomRows<3>() = edges.inverse();
  gradients.row(0) = -gradients.bottomRows<3>().colwise().sum();
  return gradients;
}

Eigen::Vector4d barycentric(const TetMesh& mesh, Eigen::Index element, const Eigen::Vector3d& point) {
  const Eigen::Vector3d from = point - mesh.points.col(mesh.tets(0, element));
  Eigen::Vector4d at = barycentric_gradients(mesh, element) * from;
  at[0] += 1.0;
  return at;
}

Eigen::Vector3d face_barycentric(const TetMesh& mesh, Eigen::Index face, const Eigen::Vector3d& point) {
  const Eigen::Vector3d a = mesh.points.col(mesh.faces(0, face)), b = mesh.points.col(mesh.faces(1, face)),
                        c = mesh.points.col(mesh.faces(2, face));
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  return Eigen::Vector3d((b - point).cross(c - point).dot(normal), (c - point).cross(a - point).dot(normal),
                         (a - point).cross(b - point).dot(normal)) /
         normal.squaredNorm();
}

const std::vector<TetPoint>& tet_rule(int degree) {
  static const std::vector<TetPoint> rules[3] = {make_tet_rule(1), make_tet_rule(2), make_tet_rule(5)};
  assert(degree <= 5);
  return rules[degree <= 1 ? 0 : degree <= 2 ? 1 : 2];
}

const std::vector<FacePoint>& face_rule(int degree) {
  static const std::vector<FacePoint> rules[3] = {make_face_rule(1), make_face_rule(2), make_face_rule(5)};
  assert(degree <= 5);
  return rules[degree <= 1 ? 0 : degree <= 2 ? 1 : 2];
}

}  // namespace thermotwin::mesh
