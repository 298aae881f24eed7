// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What manufactured solutions need beside the solver: smooth exact fields, loads and error norms by
// Gauss points that are many more than the solver's, distorted boxes, constraints by elimination.

#include <functional>
#include <random>
#include <vector>

#include "mesh/body/shape.h"
#include "solver/linear/sparse_factor.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::test {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Sum of a sin(k . x + phase): its derivatives are as simple.
struct Wave {
  Vector3d k;
  double phase, amplitude;
};
class Waves {
public:
  explicit Waves(std::vector<Wave> waves) : waves_(std::move(waves)) {}
  double value(const Vector3d& x) const {
    double sum = 0.0;
    for (const Wave& w : waves_) sum += w.amplitude * std::sin(w.k.dot(x) + w.phase);
    return sum;
  }
  Vector3d gradient(const Vector3d& x) const {
    Vector3d sum = Vector3d::Zero();
    for (const Wave& w : waves_) sum += w.amplitude * std::cos(w.k.dot(x) + w.phase) * w.k;
    return sum;
  }
  Matrix3d second(const Vector3d& x) const {
    Matrix3d sum = Matrix3d::Zero();
    for (const Wave& w : waves_) sum -= w.amplitude * std::sin(w.k.dot(x) + w.phase) * w.k * w.k.transpose();
    return sum;
  }

private:
  std::vector<Wave> waves_;
};

/// Gauss points on a line and their weights.
inline constexpr double gauss_x[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
inline constexpr double gauss_w[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};

/// Gauss points of degree 5 at least on a tetrahedron: a cube of 4 x 4 x 4, collapsed to it.
inline const std::vector<mesh::TetPoint>& fine_tet_rule() {
  static const std::vector<mesh::TetPoint> rule = [] {
    std::vector<mesh::TetPoint> made;
    double sum = 0.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        for (int l = 0; l < 4; ++l) {
          const double a = 0.5 * (1 + gauss_x[i]), b = 0.5 * (1 + gauss_x[j]) * (1 - a),
                       c = 0.5 * (1 + gauss_x[l]) * (1 - a - b);
          made.push_back(
              {Eigen::Vector4d(a, b, c, 1 - a - b - c), gauss_w[i] * gauss_w[j] * gauss_w[l] * (1 - a) * (1 - a - b)});
          sum += made.back().share;
        }
      }
    }
    for (mesh::TetPoint& point : made) point.share /= sum;
    return made;
  }();
  return rule;
}

inline const std::vector<mesh::FacePoint>& fine_face_rule() {
  static const std::vector<mesh::FacePoint> rule = [] {
    std::vector<mesh::FacePoint> made;
    double sum = 0.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double a = 0.5 * (1 + gauss_x[i]), b = 0.5 * (1 + gauss_x[j]) * (1 - a);
        made.push_back({Vector3d(a, b, 1 - a - b), gauss_w[i] * gauss_w[j] * (1 - a)});
        sum += made.back().share;
      }
    }
    for (mesh::FacePoint& point : made) point.share /= sum;
    return made;
  }();
  return rule;
}

/// Calls visit(place, weight, nodes, values, gradients) at every Gauss point of the body.
template <class Visit>
void over_volume(const mesh::TetMesh& body, const Visit& visit) {
  std::vector<mesh::TetValues> values;
  std::vector<mesh::TetSlopes> slopes;
  for (const mesh::TetPoint& point : fine_tet_rule()) {
    values.push_back(mesh::tet_shape(body.order(), point.at));
    slopes.push_back(mesh::tet_slopes(body.order(), point.at));
  }
  for (Index e = 0; e < body.elements(); ++e) {
    const mesh::TetNodes nodes = mesh::tet_nodes(body, e);
    const Eigen::Matrix<double, 4, 3> to_space = mesh::barycentric_gradients(body, e);
    const double volume = body.volume(e);
    Eigen::Matrix<double, 3, 4> corners;
    for (int i = 0; i < 4; ++i) corners.col(i) = body.points.col(nodes[i]);
    for (std::size_t p = 0; p < values.size(); ++p) {
      const mesh::TetPoint& point = fine_tet_rule()[p];
      const mesh::TetGradients gradients = slopes[p] * to_space;
      visit(Vector3d(corners * point.at), volume * point.share, nodes, values[p], gradients);
    }
  }
}

/// Calls visit(place, weight, normal, nodes, values) at every Gauss point of the triangles.
template <class Visit>
void over_surface(const mesh::TetMesh& body, const std::vector<int>& faces, const Visit& visit) {
  for (const int face : faces) {
    const mesh::FaceNodes nodes = mesh::face_nodes(body, face);
    const Vector3d normal = body.face_normal(face);
    const double area = body.face_area(face);
    Matrix3d corners;
    for (int i = 0; i < 3; ++i) corners.col(i) = body.points.col(nodes[i]);
    for (const mesh::FacePoint& point : fine_face_rule())
      visit(Vector3d(corners * point.at), area * point.share, normal, nodes, mesh::face_shape(body.order(), point.at));
  }
}

inline std::vector<int> skin(const mesh::TetMesh& body) {
  std::vector<int> faces;
  for (int f = 0; f < body.face_count(); ++f) faces.push_back(f);
  return faces;
}

/// The box with its nodes moved smoothly along its sides and inside: every refinement has the same
/// shape of elements.
inline mesh::TetMesh bent_box(const Vector3d& high, const Eigen::Vector3i& cells, int order) {
  mesh::TetMesh box = box_mesh(Vector3d::Zero(), high, cells);
  for (Index i = 0; i < box.nodes(); ++i) {
    const Vector3d at = box.points.col(i).cwiseQuotient(high);
    Vector3d moved;
    for (int k = 0; k < 3; ++k)
      moved[k] = at[k] + 0.07 * std::sin(M_PI * at[k]) * std::cos(2.0 * at[(k + 1) % 3] + 3.0 * at[(k + 2) % 3] + k);
    box.points.col(i) = moved.cwiseProduct(high);
  }
  mesh::build_boundary(box, "box");
  mesh::set_order(box, order);
  return box;
}

/// The box with inner nodes moved at random.
inline mesh::TetMesh shaken_box(const Vector3d& high, const Eigen::Vector3i& cells, int order) {
  mesh::TetMesh box = box_mesh(Vector3d::Zero(), high, cells);
  std::vector<char> outside(box.nodes(), 0);
  for (const int node : box.faces.reshaped()) outside[node] = 1;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.2, 0.2);
  for (Index i = 0; i < box.nodes(); ++i) {
    if (!outside[i])
      for (int k = 0; k < 3; ++k) box.points(k, i) += shift(random) * high[k] / cells[k];
  }
  mesh::build_boundary(box, "box");
  mesh::set_order(box, order);
  return box;
}

/// Nodes where a condition on the place holds.
inline std::vector<Index> nodes_where(const mesh::TetMesh& body,
                                      const std::function<bool(const Vector3d&)>& condition) {
  std::vector<Index> nodes;
  for (Index i = 0; i < body.nodes(); ++i)
    if (condition(body.points.col(i))) nodes.push_back(i);
  return nodes;
}

inline Index node_at(const mesh::TetMesh& body, const Vector3d& place) {
  Index node = 0;
  (body.points.colwise() - place).colwise().squaredNorm().minCoeff(&node);
  return node;
}

/// Solves K u = f with the given unknowns held at 0.
inline Eigen::VectorXd solve_held(const solver::SparseMatrix& stiffness, const Eigen::VectorXd& load,
                                  const std::vector<Index>& held) {
  std::vector<int> number(load.size(), 0);
  for (const Index dof : held) number[dof] = -1;
  int open = 0;
  for (int& n : number)
    if (n == 0) n = open++;
  std::vector<Eigen::Triplet<double>> triplets;
  for (int column = 0; column < stiffness.outerSize(); ++column) {
    for (solver::SparseMatrix::InnerIterator it(stiffness, column); it; ++it) {
      const int i = number[it.row()], j = number[column];
      if (i >= 0 && j >= 0) triplets.emplace_back(i, j, it.value());
    }
  }
  solver::SparseMatrix kept(open, open);
  kept.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::MatrixXd right(open, 1);
  for (Index i = 0; i < load.size(); ++i)
    if (number[i] >= 0) right(number[i], 0) = load[i];
  const Eigen::VectorXd solved = solver::SparseFactor(kept).solve(right).col(0);
  Eigen::VectorXd full = Eigen::VectorXd::Zero(load.size());
  for (Index i = 0; i < load.size(); ++i)
    if (number[i] >= 0) full[i] = solved[number[i]];
  return full;
}

}  // namespace thermotwin::test
