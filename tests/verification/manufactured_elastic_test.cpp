// SPDX-License-Identifier: GPL-3.0-or-later
// Observed orders of elasticity against a manufactured solution with a temperature field, body
// forces and tractions, on bent meshes.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "solver/elastic/assembly.h"
#include "tests/verification/fields.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

struct Exact {
  std::array<Waves, 3> u;
  Waves temperature;
  double lambda, mu, thermal;

  Matrix3d gradient(const Vector3d& x) const {
    Matrix3d g;
    for (int i = 0; i < 3; ++i) g.row(i) = u[i].gradient(x);
    return g;
  }
  Vector3d value(const Vector3d& x) const { return {u[0].value(x), u[1].value(x), u[2].value(x)}; }
  Matrix3d stress(const Vector3d& x) const {
    const Matrix3d g = gradient(x), strain = 0.5 * (g + g.transpose());
    return 2.0 * mu * strain + (lambda * strain.trace() - thermal * temperature.value(x)) * Matrix3d::Identity();
  }
  Vector3d body_force(const Vector3d& x) const {
    Vector3d divergence = -thermal * temperature.gradient(x);
    for (int i = 0; i < 3; ++i) {
      const Matrix3d second = u[i].second(x);
      divergence[i] += mu * second.trace();
      divergence += (lambda + mu) * second.col(i);
    }
    return -divergence;
  }
};

Exact exact_fields(const mesh::Material& m) {
  return {{Waves({{{2.0, 1.0, -1.5}, 0.3, 2e-5}, {{0.0, 1.5, 1.0}, 0.1, 1e-5}}), Waves({{{-1.0, 1.5, 1.0}, 1.1, 1e-5}}),
           Waves({{{0.5, -1.0, 2.0}, -0.4, 1.5e-5}})},
          Waves({{{1.5, -1.0, 1.5}, 0.7, 3.0}}),
          m.young * m.poisson / ((1 + m.poisson) * (1 - 2 * m.poisson)),
          m.young / (2 * (1 + m.poisson)),
          m.young * m.expansion.value / (1 - 2 * m.poisson)};
}

struct Errors {
  double displacement = 0, strain = 0;  ///< L2 norms
};

/// Displacements given on four sides, tractions on two. (Under tractions alone linear elements keep
/// a part of their locking until they are very small.)
Errors errors_on(const mesh::TetMesh& box, const Vector3d& size) {
  const mesh::Material material = steel();
  const Exact exact = exact_fields(material);
  Eigen::VectorXd temperature(box.nodes());
  for (Index i = 0; i < box.nodes(); ++i) temperature[i] = exact.temperature.value(box.points.col(i));
  Eigen::VectorXd load = solver::thermal_load(box, material) * temperature;
  over_volume(
      box, [&](const Vector3d& at, double weight, const mesh::TetNodes& nodes, const mesh::TetValues& n, const auto&) {
        const Vector3d force = exact.body_force(at);
        for (Index i = 0; i < nodes.size(); ++i) load.segment<3>(3 * nodes[i]) += weight * n[i] * force;
      });
  for (const char* side : {"z0", "z1"}) {
    over_surface(box, box.groups.at(side),
                 [&](const Vector3d& at, double weight, const Vector3d& normal, const mesh::FaceNodes& nodes,
                     const mesh::FaceValues& n) {
                   const Vector3d traction = exact.stress(at) * normal;
                   for (Index i = 0; i < nodes.size(); ++i) load.segment<3>(3 * nodes[i]) += weight * n[i] * traction;
                 });
  }
  Eigen::VectorXd given = Eigen::VectorXd::Zero(3 * box.nodes());
  std::vector<Index> held;
  for (const Index node : nodes_where(box, [&](const Vector3d& p) {
         return std::min({p.x(), p.y(), size.x() - p.x(), size.y() - p.y()}) < 1e-9;
       })) {
    given.segment<3>(3 * node) = exact.value(box.points.col(node));
    for (int k = 0; k < 3; ++k) held.push_back(3 * node + k);
  }
  const solver::SparseMatrix stiffness = solver::elastic_stiffness(box, material);
  const Eigen::VectorXd u = given + solve_held(stiffness, load - stiffness * given, held);

  Errors errors;
  over_volume(box, [&](const Vector3d& at, double weight, const mesh::TetNodes& nodes, const mesh::TetValues& n,
                       const mesh::TetGradients& g) {
    Vector3d difference = -exact.value(at);
    Matrix3d slope = -exact.gradient(at);
    for (Index i = 0; i < nodes.size(); ++i) {
      difference += n[i] * u.segment<3>(3 * nodes[i]);
      slope += u.segment<3>(3 * nodes[i]) * g.row(i);
    }
    errors.displacement += weight * difference.squaredNorm();
    errors.strain += weight * (0.5 * (slope + slope.transpose())).squaredNorm();
  });
  return {std::sqrt(errors.displacement), std::sqrt(errors.strain)};
}

TEST(ManufacturedElasticity, OrdersInSpace) {
  for (int order : {1, 2}) {
    const int cells = order == 1 ? 8 : 4;
    const Vector3d size(1.0, 0.8, 0.6);
    const Errors coarse = errors_on(bent_box(size, Eigen::Vector3i::Constant(cells), order), size);
    const Errors fine = errors_on(bent_box(size, Eigen::Vector3i::Constant(2 * cells), order), size);
    const std::string name = std::string("thermo-elasticity, ") + (order == 1 ? "P1" : "P2");
    expect_order({name, "manufactured, with temperature", "order of the L2 error of u"}, order + 1,
                 std::log2(coarse.displacement / fine.displacement));
    expect_order({name, "manufactured, with temperature", "order of the L2 error of strain"}, order,
                 std::log2(coarse.strain / fine.strain));
  }
}

}  // namespace
}  // namespace thermotwin::test
