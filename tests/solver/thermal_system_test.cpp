// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "core/error.h"
#include "tests/solver/small_machine.h"

namespace thermotwin::solver {

namespace {

const ThermalSystem& slide_system() {
  static const ThermalSystem system = assemble_thermal(test::slide_mesh());
  return system;
}

Eigen::VectorXd ones(const ThermalSystem& s) { return Eigen::VectorXd::Ones(s.size); }

}  // namespace

TEST(ThermalSystem, CapacityHoldsTheWholeHeat) {
  const ThermalSystem& s = slide_system();
  const double volume = 0.6 * 0.12 * 0.1 + 0.1 * 0.1 * 0.059;
  EXPECT_NEAR(ones(s).dot(s.capacity * ones(s)), volume * 7800 * 470 + 3e-4 * 815 * 1940, 1e-6);
  EXPECT_LT((s.conduction * ones(s)).norm(), 1e-9);
}

TEST(ThermalSystem, TermsAreNonNegativeAndFlowsDissipate) {
  const ThermalSystem& s = slide_system();
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (std::size_t t = 0; t < s.terms.size(); ++t) {
    const SparseMatrix transposed = s.terms[t].transpose();
    const double asymmetry = (s.terms[t] - transposed).norm();
    if (s.layout.terms[t].kind == TermKind::coolant_flow) {
      EXPECT_GT(asymmetry, 0.0);
    } else {
      EXPECT_LT(asymmetry, 1e-12 * s.terms[t].norm());
    }
    for (int i = 0; i < 50; ++i) {
      Eigen::VectorXd x(s.size);
      for (double& v : x) v = normal(random);
      // x^T G x = x^T (G + G^T) x / 2
      EXPECT_GE(x.dot(s.terms[t] * x), -1e-12 * s.terms[t].norm() * x.squaredNorm()) << t;
    }
  }
}

TEST(ThermalSystem, ContactsAndWallsKeepTheHeat) {
  const ThermalSystem& s = slide_system();
  for (std::size_t t = 0; t < s.terms.size(); ++t) {
    const Term& term = s.layout.terms[t];
    const bool inner = (term.kind == TermKind::contact && term.item == 0) || term.kind == TermKind::coolant_wall;
    if (!inner) continue;
    // Uniform temperature drives nothing, and what leaves one side enters the other.
    EXPECT_LT((s.terms[t] * ones(s)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_GT(s.terms[t].norm(), 0.0);
  }
}

TEST(ThermalSystem, SourcesGiveTheirPowerAtEveryPosition) {
  const ThermalSystem& s = slide_system();
  int at_joint = 0;
  for (std::size_t k = 0; k < s.layout.inputs.size(); ++k) {
    const Input& input = s.layout.inputs[k];
    const Eigen::VectorXd column = s.inputs.col(static_cast<Eigen::Index>(k));
    if (input.kind == InputKind::source) {
      EXPECT_NEAR(column.sum(), 1.0, 1e-12);
      if (input.item == 0 && input.place == 1) {
        ++at_joint;
        EXPECT_NEAR(column.head(10 * 4 * 3).sum(), 0.7, 1e-12);  // the bed's side
      }
    }
    // A uniform temperature equal to the ambient stands: K_j 1 = B_j
    if (input.kind == InputKind::film_ambient || input.kind == InputKind::contact_ambient) {
      EXPECT_LT((s.terms[static_cast<std::size_t>(input.term)] * ones(s) - column).cwiseAbs().maxCoeff(), 1e-14);
    }
  }
  EXPECT_EQ(at_joint, static_cast<int>(s.layout.grids[0].positions.size()));
}

TEST(ThermalSystem, SensorsInterpolateLinearFields) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const ThermalSystem& s = slide_system();
  Eigen::VectorXd field = Eigen::VectorXd::Zero(s.size);
  const Eigen::Vector3d slope(3.0, -2.0, 5.0);
  for (std::size_t b = 0; b < 2; ++b)
    field.segment(mesh.first_node[b], mesh.bodies[b].nodes()) = mesh.bodies[b].points.transpose() * slope;
  const Eigen::VectorXd readings = s.sensors * field;
  EXPECT_NEAR(readings[0], slope.dot(Eigen::Vector3d(0.31, 0.047, 0.033)), 1e-12);
  EXPECT_NEAR(readings[1], slope.dot(Eigen::Vector3d(0.3, 0.06, 0.16)), 1e-12);
}

TEST(ThermalSystem, RefusesAJointThatNeverTouches) {
  mesh::Machine machine = test::slide_machine();
  machine.joints[0].reach = 0.0005;
  EXPECT_THROW(assemble_thermal(test::slide_mesh(1, machine)), core::InputError);
}

TEST(ThermalSystem, ShiftedSolvesAndTheirTransposes) {
  const ThermalSystem& s = slide_system();
  Coefficients c;
  c.p = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(s.terms.size()), 3.0, 40.0);
  c.q = Eigen::VectorXd::Zero(s.inputs.cols());
  SparseMatrix a = 0.01 * s.capacity + s.conduction;
  for (std::size_t t = 0; t < s.terms.size(); ++t) a += c.p[static_cast<Eigen::Index>(t)] * s.terms[t];
  const Eigen::MatrixXd b = s.inputs;
  EXPECT_LT((a * solve_shifted(s, c, 0.01, b) - b).norm(), 1e-10 * b.norm());
  EXPECT_LT((a.transpose() * solve_shifted(s, c, 0.01, b, true) - b).norm(), 1e-10 * b.norm());
  EXPECT_GT((solve_shifted(s, c, 0.01, b) - solve_shifted(s, c, 0.01, b, true)).norm(), 0.0);
}

TEST(ThermalSystem, AFloatingBodyHasNoSteadyState) {
  const ThermalSystem& s = slide_system();
  Coefficients c;
  c.p = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(s.terms.size()));
  c.q = Eigen::VectorXd::Zero(s.inputs.cols());
  EXPECT_THROW(solve_steady(s, c), core::SolverError);
}

}  // namespace thermotwin::solver
