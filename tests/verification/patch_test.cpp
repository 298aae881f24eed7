// SPDX-License-Identifier: GPL-3.0-or-later
// What must come out exactly, on boxes with nodes moved at random: fields that the elements can
// represent, rigid motions, even warming, and a bar that bends under a gradient.
#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "solver/elastic/stress.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/system.h"
#include "tests/verification/fields.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

const Vector3d size(0.4, 0.3, 0.2);
const Eigen::Vector3i cells(4, 3, 3);

std::string named(const char* name, int order) { return std::string(name) + (order == 1 ? ", P1" : ", P2"); }

/// Takes the mean rigid motion out.
Eigen::VectorXd without_rigid(const solver::ElasticBody& body, const Eigen::VectorXd& motion) {
  const Eigen::MatrixXd& r = body.rigid;
  return motion - r * (r.transpose() * r).ldlt().solve(r.transpose() * motion);
}

Eigen::VectorXd free_motion(const solver::ElasticBody& body, Eigen::MatrixXd load) {
  solver::clear_fixed(body, load);
  return solver::SparseFactor(body.stiffness).solve(load).col(0);
}

/// T = c + b x + x A x / 2 with A = 0 for linear elements, full conductivity tensor, film all round.
TEST(Patch, Heat) {
  for (int order : {1, 2}) {
    const mesh::TetMesh box = shaken_box(size, cells, order);
    mesh::Machine machine;
    machine.reference_C = 0.0;
    machine.materials = {steel()};
    const Matrix3d tensor = (Matrix3d() << 30, 8, -5, 8, 20, 4, -5, 4, 12).finished();
    machine.materials[0].conductivity_tensor = tensor;
    machine.bodies = {body("box")};
    machine.surfaces = {surface("skin", "box")};
    machine.ambients = {ambient("air", 0.0)};
    machine.films = {constant_film("skin", {"skin"}, 25.0)};
    const solver::ThermalSystem system = solver::assemble_thermal(machine_mesh(machine, {box}));
    const Vector3d slope(30, -20, 50);
    const Matrix3d curve =
        order == 1 ? Matrix3d::Zero().eval() : (Matrix3d() << 100, 40, -30, 40, -200, 60, -30, 60, 150).finished();
    const auto exact = [&](const Vector3d& x) { return 7.0 + slope.dot(x) + 0.5 * x.dot(curve * x); };
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(system.size, 1);
    over_volume(
        box, [&](const Vector3d&, double weight, const mesh::TetNodes& nodes, const mesh::TetValues& n, const auto&) {
          for (Index i = 0; i < nodes.size(); ++i)
            load(nodes[i], 0) -= weight * n[i] * tensor.cwiseProduct(curve).sum();
        });
    over_surface(box, skin(box),
                 [&](const Vector3d& at, double weight, const Vector3d& normal, const mesh::FaceNodes& nodes,
                     const mesh::FaceValues& n) {
                   const double flux = normal.dot(tensor * (slope + curve * at)) + 25.0 * exact(at);
                   for (Index i = 0; i < nodes.size(); ++i) load(nodes[i], 0) += weight * n[i] * flux;
                 });
    solver::Coefficients c;
    c.p = Eigen::VectorXd::Constant(1, 25.0);
    const Eigen::VectorXd t = solver::solve_shifted(system, c, 0.0, load);
    double worst = 0.0;
    for (Index i = 0; i < box.nodes(); ++i) worst = std::max(worst, std::abs(t[i] - exact(box.points.col(i))));
    expect_below({named("patch test, heat", order), order == 1 ? "exact, linear T" : "exact, quadratic T with a source",
                  "largest error of T over its range"},
                 1e-11, worst / 40.0);
  }
}

/// u = B x + (x A_i x / 2)_i and T = c + b x + x D x / 2; A and D zero for linear elements.
TEST(Patch, Elasticity) {
  for (int order : {1, 2}) {
    const mesh::TetMesh box = shaken_box(size, cells, order);
    const mesh::Material m = steel();
    const double lambda = m.young * m.poisson / ((1 + m.poisson) * (1 - 2 * m.poisson)),
                 mu = m.young / (2 * (1 + m.poisson));
    const double thermal = m.young * m.expansion.value / (1 - 2 * m.poisson), scale = 1e-5,
                 curved = order == 1 ? 0.0 : 1.0;
    const Matrix3d slope = scale * (Matrix3d() << 2, -1, 3, 0.5, 1, -2, 1, 4, -3).finished();
    std::array<Matrix3d, 3> curve;
    for (int i = 0; i < 3; ++i)
      curve[i] = curved * scale * (Matrix3d() << 4 - i, 3, -2, 3, 1 + 2 * i, 5, -2, 5, 7 - 3 * i).finished();
    const Vector3d warm_slope(3, -4, 2);
    const Matrix3d warm_curve = curved * (Matrix3d() << 5, 2, 1, 2, -6, 3, 1, 3, 4).finished();
    const auto temperature = [&](const Vector3d& x) { return 2.0 + warm_slope.dot(x) + 0.5 * x.dot(warm_curve * x); };
    const auto motion = [&](const Vector3d& x) {
      Vector3d u = slope * x;
      for (int i = 0; i < 3; ++i) u[i] += 0.5 * x.dot(curve[i] * x);
      return u;
    };
    const auto gradient = [&](const Vector3d& x) {
      Matrix3d g = slope;
      for (int i = 0; i < 3; ++i) g.row(i) += (curve[i] * x).transpose();
      return g;
    };
    const auto stress = [&](const Vector3d& x) {
      const Matrix3d g = gradient(x), strain = 0.5 * (g + g.transpose());
      return Matrix3d(2 * mu * strain + (lambda * strain.trace() - thermal * temperature(x)) * Matrix3d::Identity());
    };
    const auto force = [&](const Vector3d& x) {
      Vector3d divergence = -thermal * (warm_slope + warm_curve * x);
      for (int i = 0; i < 3; ++i) {
        divergence[i] += mu * curve[i].trace();
        divergence += (lambda + mu) * curve[i].col(i);
      }
      return Vector3d(-divergence);
    };
    const solver::ElasticBody body = solver::assemble_elastic(box, m, "box");
    Eigen::VectorXd warm(box.nodes()), exact(3 * box.nodes());
    for (Index i = 0; i < box.nodes(); ++i) {
      warm[i] = temperature(box.points.col(i));
      exact.segment<3>(3 * i) = motion(box.points.col(i));
    }
    Eigen::MatrixXd load = body.thermal_load * warm;
    over_volume(box, [&](const Vector3d& at, double weight, const mesh::TetNodes& nodes, const mesh::TetValues& n,
                         const auto&) {
      for (Index i = 0; i < nodes.size(); ++i) load.block<3, 1>(3 * nodes[i], 0) += weight * n[i] * force(at);
    });
    over_surface(box, skin(box),
                 [&](const Vector3d& at, double weight, const Vector3d& normal, const mesh::FaceNodes& nodes,
                     const mesh::FaceValues& n) {
                   for (Index i = 0; i < nodes.size(); ++i)
                     load.block<3, 1>(3 * nodes[i], 0) += weight * n[i] * stress(at) * normal;
                 });
    const Eigen::VectorXd u = free_motion(body, load);
    const std::string source = order == 1 ? "exact, linear u and T" : "exact, quadratic u and T";
    expect_below({named("patch test, thermo-elasticity", order), source, "largest error of u over largest u"}, 1e-10,
                 without_rigid(body, u - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff());
    double worst = 0.0;
    for (Index e = 0; e < box.elements(); ++e) {
      const Eigen::Vector4d at(0.1, 0.2, 0.3, 0.4);
      Vector3d place = Vector3d::Zero();
      for (int i = 0; i < 4; ++i) place += at[i] * box.points.col(box.tets(i, e));
      const Matrix3d s = stress(place);
      const solver::Vector6 ours = solver::stress_at(box, m, u, warm, e, at);
      worst = std::max(worst,
                       (ours - (solver::Vector6() << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0)).finished())
                           .cwiseAbs()
                           .maxCoeff());
    }
    expect_below({named("patch test, thermo-elasticity", order), source, "largest error of stress over E alpha 1 K"},
                 1e-9, worst / thermal);
  }
}

TEST(Patch, RigidMotionAndEvenWarmingLeaveNoStress) {
  for (int order : {1, 2}) {
    const mesh::TetMesh box = shaken_box(size, cells, order);
    const mesh::Material m = steel();
    const solver::ElasticBody body = solver::assemble_elastic(box, m, "box");
    const double scale = m.young * m.expansion.value * 3.0;
    const Eigen::VectorXd cold = Eigen::VectorXd::Zero(box.nodes()), warm = Eigen::VectorXd::Constant(box.nodes(), 3.0);
    // As large a motion as a heated body makes.
    const Eigen::VectorXd rigid = 1e-5 * body.rigid * (Eigen::VectorXd(6) << 1, -2, 3, 0.3, -0.2, 0.1).finished();
    expect_below({named("rigid motion", order), "exact", "largest stress over E alpha 3 K"}, 1e-10,
                 solver::StressRecovery(box).nodal(m, rigid, cold).cwiseAbs().maxCoeff() / scale);
    const Eigen::VectorXd u = free_motion(body, body.thermal_load * warm);
    expect_below({named("even warming of a free body", order), "exact", "largest stress over E alpha 3 K"}, 1e-9,
                 solver::StressRecovery(box).nodal(m, u, warm).cwiseAbs().maxCoeff() / scale);
    Eigen::VectorXd exact(3 * box.nodes());
    for (Index i = 0; i < box.nodes(); ++i) exact.segment<3>(3 * i) = m.expansion.value * 3.0 * box.points.col(i);
    EXPECT_LT(without_rigid(body, u - exact).cwiseAbs().maxCoeff(), 1e-10 * exact.cwiseAbs().maxCoeff());
  }
}

TEST(Patch, LinearStressIsRecoveredAtTheNodes) {
  // A bar bent by end moments: sigma_xx = E kappa z.
  const mesh::TetMesh bar = shaken_box(size, cells, 2);
  mesh::Material m = steel();
  const double curvature = 1e-4;
  Eigen::VectorXd u(3 * bar.nodes());
  for (Index i = 0; i < bar.nodes(); ++i) {
    const Vector3d p = bar.points.col(i);
    u.segment<3>(3 * i) = curvature * Vector3d(p.x() * p.z(), -m.poisson * p.y() * p.z(),
                                               -0.5 * (p.x() * p.x() + m.poisson * (p.z() * p.z() - p.y() * p.y())));
  }
  const Eigen::MatrixXd stress = solver::StressRecovery(bar).nodal(m, u, Eigen::VectorXd::Zero(bar.nodes()));
  Eigen::MatrixXd exact = Eigen::MatrixXd::Zero(6, bar.nodes());
  exact.row(0) = m.young * curvature * bar.points.row(2);
  expect_below({"bar bent by moments, P2", "exact", "largest error of nodal stress over largest stress"}, 1e-10,
               (stress - exact).cwiseAbs().maxCoeff() / exact.maxCoeff());
  EXPECT_NEAR(solver::von_mises(stress).maxCoeff(), exact.maxCoeff(), 1e-9 * exact.maxCoeff());
}

TEST(BendingBar, UnderALinearGradient) {
  // T = g z leaves a free bar without stress: u = alpha g (x z, y z, (z^2 - x^2 - y^2) / 2).
  const mesh::Material m = steel();
  const double gradient = 40.0;
  const auto bend = [&](const Eigen::Vector3i& divide, int order, double& error) {
    mesh::TetMesh bar = box_mesh({-0.2, -0.05, -0.05}, {0.2, 0.05, 0.05}, divide);
    mesh::set_order(bar, order);
    const solver::ElasticBody body = solver::assemble_elastic(bar, m, "bar");
    const Eigen::VectorXd warm = gradient * bar.points.row(2).transpose();
    const Eigen::VectorXd u = without_rigid(body, free_motion(body, body.thermal_load * warm));
    Eigen::VectorXd exact(3 * bar.nodes());
    for (Index i = 0; i < bar.nodes(); ++i) {
      const Vector3d p = bar.points.col(i);
      exact.segment<3>(3 * i) =
          m.expansion.value * gradient *
          Vector3d(p.x() * p.z(), p.y() * p.z(), 0.5 * (p.z() * p.z() - p.x() * p.x() - p.y() * p.y()));
    }
    exact = without_rigid(body, exact);
    error = (u - exact).norm() / exact.norm();
    return u.dot(exact) / exact.squaredNorm();  // share of the exact deflection
  };
  const Figure figure{"", "exact: u = alpha g (xz, yz, (z^2 - x^2 - y^2)/2)", "deflection, % of exact"};
  double error = 0.0, before = 0.0;
  const auto row = [&](const char* name, double share, double tolerance) {
    expect_value({name, figure.source, figure.quantity}, 100.0, 100.0 * share, tolerance);
  };
  row("bending bar, P1, one element over the height", bend({4, 1, 1}, 1, error), 80.0);
  row("bending bar, P1, four elements", bend({16, 4, 4}, 1, before), 26.0);
  row("bending bar, P1, eight elements", bend({32, 8, 8}, 1, error), 9.0);
  EXPECT_LT(error, 0.4 * before);  // second order
  row("bending bar, P2, one element over the height", bend({4, 1, 1}, 2, error), 1e-6);
  expect_below({"bending bar, P2, one element over the height", figure.source, "error of u over u"}, 1e-10, error);
}

}  // namespace
}  // namespace thermotwin::test
