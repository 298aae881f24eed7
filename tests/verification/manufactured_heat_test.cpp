// SPDX-License-Identifier: GPL-3.0-or-later
// Observed orders of the heat equation, in space against a manufactured solution with a full
// conductivity tensor on bent meshes, in time against an exact decay.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "solver/thermal/system.h"
#include "tests/verification/fields.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

using solver::ThermalSystem;

const char* words(int order) { return order == 1 ? "P1" : "P2"; }

mesh::Material oblique() {
  mesh::Material material = steel();
  material.conductivity_tensor = (Matrix3d() << 30, 8, -5, 8, 20, 4, -5, 4, 12).finished();
  return material;
}

/// One box with a film on all sides.
mesh::MachineMesh block(mesh::TetMesh box, const mesh::Material& material) {
  mesh::Machine machine;
  machine.reference_C = 0.0;
  machine.materials = {material};
  machine.bodies = {body("block")};
  machine.surfaces = {surface("skin", "block")};
  machine.ambients = {ambient("air", 0.0)};
  machine.films = {constant_film("skin", {"skin"}, 40.0)};
  machine.order = box.order();
  return machine_mesh(machine, {std::move(box)});
}

struct HeatErrors {
  double value = 0, gradient = 0;  ///< L2 norms
};

/// div(K grad T) + f = 0 inside, n K grad T + h T = g on the skin, with f and g of the exact field.
HeatErrors steady_errors(const mesh::TetMesh& box, const Waves& exact) {
  const double film = 40.0;
  const mesh::Material material = oblique();
  const Matrix3d tensor = *material.conductivity_tensor;
  const mesh::MachineMesh mesh = block(box, material);
  const ThermalSystem system = solver::assemble_thermal(mesh);
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(system.size, 1);
  over_volume(
      box, [&](const Vector3d& at, double weight, const mesh::TetNodes& nodes, const mesh::TetValues& n, const auto&) {
        const double source = -tensor.cwiseProduct(exact.second(at)).sum();
        for (Index i = 0; i < nodes.size(); ++i) load(nodes[i], 0) += weight * source * n[i];
      });
  over_surface(box, skin(box),
               [&](const Vector3d& at, double weight, const Vector3d& normal, const mesh::FaceNodes& nodes,
                   const mesh::FaceValues& n) {
                 const double flux = normal.dot(tensor * exact.gradient(at)) + film * exact.value(at);
                 for (Index i = 0; i < nodes.size(); ++i) load(nodes[i], 0) += weight * flux * n[i];
               });
  solver::Coefficients c;
  c.p = Eigen::VectorXd::Constant(1, film);
  c.q = Eigen::VectorXd::Zero(system.inputs.cols());
  const Eigen::VectorXd t = solver::solve_shifted(system, c, 0.0, load);
  HeatErrors errors;
  over_volume(box, [&](const Vector3d& at, double weight, const mesh::TetNodes& nodes, const mesh::TetValues& n,
                       const mesh::TetGradients& g) {
    double value = 0.0;
    Vector3d gradient = Vector3d::Zero();
    for (Index i = 0; i < nodes.size(); ++i) {
      value += n[i] * t[nodes[i]];
      gradient += t[nodes[i]] * g.row(i).transpose();
    }
    errors.value += weight * std::pow(value - exact.value(at), 2);
    errors.gradient += weight * (gradient - exact.gradient(at)).squaredNorm();
  });
  return {std::sqrt(errors.value), std::sqrt(errors.gradient)};
}

TEST(ManufacturedHeat, OrdersInSpace) {
  const Waves exact({{{3.0, 1.0, -2.0}, 0.3, 2.0}, {{-1.0, 2.5, 1.5}, 1.1, 1.0}, {{0.5, -1.5, 4.0}, -0.4, 0.7}});
  for (int order : {1, 2}) {
    const int cells = order == 1 ? 10 : 6;
    const HeatErrors coarse = steady_errors(bent_box({1.0, 0.8, 0.6}, Eigen::Vector3i::Constant(cells), order), exact);
    const HeatErrors fine =
        steady_errors(bent_box({1.0, 0.8, 0.6}, Eigen::Vector3i::Constant(2 * cells), order), exact);
    const std::string name = std::string("heat in space, ") + words(order);
    expect_order({name, "manufactured, full conductivity tensor", "order of the L2 error of T"}, order + 1,
                 std::log2(coarse.value / fine.value));
    expect_order({name, "manufactured, full conductivity tensor", "order of the L2 error of grad T"}, order,
                 std::log2(coarse.gradient / fine.gradient));
  }
}

TEST(ManufacturedHeat, OrdersInTime) {
  // An eigenvector of the assembled matrices decays by exp(-lambda t).
  const mesh::MachineMesh mesh = block(bent_box({0.1, 0.08, 0.06}, {2, 2, 2}, 2), oblique());
  const ThermalSystem system = solver::assemble_thermal(mesh);
  solver::Coefficients c;
  c.p = Eigen::VectorXd::Constant(1, 40.0);
  c.q = Eigen::VectorXd::Zero(system.inputs.cols());
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(
      Eigen::MatrixXd(system.conduction + 40.0 * system.terms[0]), Eigen::MatrixXd(system.capacity));
  const double rate = modes.eigenvalues()[2], duration = 2.0 / rate;
  const Eigen::VectorXd start = modes.eigenvectors().col(2), end = std::exp(-2.0) * start;
  for (const bool backward_euler : {true, false}) {
    const auto error = [&](int steps) {
      solver::IntegratorOptions options;
      options.tolerance = 1e-13;
      options.backward_euler = backward_euler;
      solver::ThermalIntegrator integrator(system, options);
      Eigen::MatrixXd state = start;
      for (int i = 0; i < steps; ++i) integrator.advance(state, {c}, duration / steps);
      return (state.col(0) - end).norm() / end.norm();
    };
    expect_order({std::string("heat in time, ") + (backward_euler ? "backward Euler" : "SDIRK2"),
                  "decay of an eigenvector, P2", "order of the error of T"},
                 backward_euler ? 1 : 2, std::log2(error(40) / error(80)));
  }
}

TEST(ManufacturedHeat, ALumpedCapacityKeepsSecondOrder) {
  // The slowest cosine in an insulated bar decays by exp(-k/(rho c) (pi/L)^2 t).
  const Vector3d size(0.1, 0.04, 0.04);
  const double duration = 100.0;
  const mesh::Material material = steel();
  const double exponent = material.conductivity / (material.density * material.specific_heat.value) *
                          std::pow(M_PI / size[0], 2) * duration;
  for (int order : {1, 2}) {
    const auto error = [&](int cells) {
      const mesh::TetMesh bar = bent_box(size, {5 * cells, 2 * cells, 2 * cells}, order);
      mesh::MachineMesh mesh = block(bar, material);
      mesh.machine.lumped_capacity = true;
      const ThermalSystem system = solver::assemble_thermal(mesh);
      EXPECT_EQ(system.capacity.nonZeros(), system.size);
      EXPECT_GT(system.capacity.diagonal().minCoeff(), 0.0);
      EXPECT_NEAR(system.capacity.diagonal().sum(), size.prod() * material.density * material.specific_heat.value,
                  1e-9);
      solver::Coefficients c;
      c.p = Eigen::VectorXd::Zero(1);
      c.q = Eigen::VectorXd::Zero(system.inputs.cols());
      solver::ThermalIntegrator integrator(system);
      const Eigen::VectorXd mode = (M_PI / size[0] * bar.points.row(0).transpose().array()).cos().matrix();
      Eigen::MatrixXd state = mode;
      for (int i = 0; i < 200; ++i) integrator.advance(state, {c}, duration / 200);
      return (state.col(0) - std::exp(-exponent) * mode).norm() / mode.norm();
    };
    const int cells = order == 1 ? 3 : 2;
    expect_order({std::string("heat, lumped capacity, ") + words(order), "decay of a cosine in a bar",
                  "order of the error of T at the end"},
                 2, std::log2(error(cells) / error(2 * cells)));
  }
}

}  // namespace
}  // namespace thermotwin::test
