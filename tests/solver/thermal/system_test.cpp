// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/system.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <iterator>
#include <random>

#include "core/error.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {

namespace {

const mesh::MachineMesh& slide(int order) {
  static const mesh::MachineMesh meshes[] = {test::slide_mesh(), test::with_order(test::slide_mesh(), 2)};
  return meshes[order - 1];
}

const ThermalSystem& slide_system(int order) {
  static const ThermalSystem systems[] = {assemble_thermal(slide(1)), assemble_thermal(slide(2))};
  return systems[order - 1];
}

Eigen::VectorXd ones(const ThermalSystem& s) { return Eigen::VectorXd::Ones(s.size); }

/// Linear and quadratic tetrahedra.
class ThermalSystemOfOrder : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, ThermalSystemOfOrder, ::testing::Values(1, 2));

}  // namespace

TEST_P(ThermalSystemOfOrder, CapacityHoldsTheWholeHeat) {
  const ThermalSystem& s = slide_system(GetParam());
  const double volume = 0.6 * 0.12 * 0.1 + 0.1 * 0.1 * 0.059;
  EXPECT_NEAR(ones(s).dot(s.capacity * ones(s)), volume * 7800 * 470 + 3e-4 * 815 * 1940, 1e-6);
  EXPECT_LT((s.conduction * ones(s)).norm(), 1e-9);
}

TEST_P(ThermalSystemOfOrder, TermsAreNonNegativeAndFlowsDissipate) {
  const ThermalSystem& s = slide_system(GetParam());
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

TEST_P(ThermalSystemOfOrder, ContactsAndWallsKeepTheHeat) {
  const ThermalSystem& s = slide_system(GetParam());
  for (std::size_t t = 0; t < s.terms.size(); ++t) {
    const Term& term = s.layout.terms[t];
    const bool inner = (term.kind == TermKind::contact && term.item == 0) || term.kind == TermKind::coolant_wall;
    if (!inner) continue;
    // Uniform temperature drives nothing, and what leaves one side enters the other.
    EXPECT_LT((s.terms[t] * ones(s)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_GT(s.terms[t].norm(), 0.0);
  }
}

TEST_P(ThermalSystemOfOrder, SourcesGiveTheirPowerAtEveryPosition) {
  const ThermalSystem& s = slide_system(GetParam());
  int at_joint = 0;
  for (std::size_t k = 0; k < s.layout.inputs.size(); ++k) {
    const Input& input = s.layout.inputs[k];
    const Eigen::VectorXd column = s.inputs.col(k);
    if (input.kind == InputKind::source) {
      EXPECT_NEAR(column.sum(), 1.0, 1e-12);
      if (input.item == 0 && input.place == 1) {
        ++at_joint;
        EXPECT_NEAR(column.head(slide(GetParam()).first_node[1]).sum(), 0.7, 1e-12);  // the bed's side
      }
    }
    // A uniform temperature equal to the ambient stands: K_j 1 = B_j
    if (input.kind == InputKind::film_ambient || input.kind == InputKind::contact_ambient) {
      EXPECT_LT((s.terms[input.term] * ones(s) - column).cwiseAbs().maxCoeff(), 1e-14);
    }
  }
  EXPECT_EQ(at_joint, std::ssize(s.layout.grids[0].positions));
}

TEST_P(ThermalSystemOfOrder, SensorsInterpolateLinearFields) {
  const mesh::MachineMesh& mesh = slide(GetParam());
  const ThermalSystem& s = slide_system(GetParam());
  Eigen::VectorXd field = Eigen::VectorXd::Zero(s.size);
  const Eigen::Vector3d slope(3.0, -2.0, 5.0);
  for (std::size_t b = 0; b < 2; ++b)
    field.segment(mesh.first_node[b], mesh.bodies[b].nodes()) = mesh.bodies[b].points.transpose() * slope;
  const Eigen::VectorXd readings = s.sensors * field;
  EXPECT_NEAR(readings[0], slope.dot(Eigen::Vector3d(0.31, 0.047, 0.033)), 1e-12);
  EXPECT_NEAR(readings[1], slope.dot(Eigen::Vector3d(0.3, 0.06, 0.16)), 1e-12);
}

TEST(ThermalSystem, SensorsInterpolateQuadraticFieldsOnAQuadraticMesh) {
  const mesh::MachineMesh& mesh = slide(2);
  const ThermalSystem& s = slide_system(2);
  const auto field = [](const Eigen::Vector3d& p) {
    return 3.0 * p.x() * p.x() - 2.0 * p.x() * p.y() + 5.0 * p.z() * p.z();
  };
  Eigen::VectorXd state = Eigen::VectorXd::Zero(s.size);
  for (std::size_t b = 0; b < 2; ++b) {
    for (Eigen::Index i = 0; i < mesh.bodies[b].nodes(); ++i)
      state[mesh.first_node[b] + i] = field(mesh.bodies[b].points.col(i));
  }
  const Eigen::VectorXd readings = s.sensors * state;
  EXPECT_NEAR(readings[0], field({0.31, 0.047, 0.033}), 1e-12);
  EXPECT_NEAR(readings[1], field({0.3, 0.06, 0.16}), 1e-12);  // on the skin
}

TEST(ThermalSystem, FilmsAndContactsIntegrateQuadraticFieldsExactly) {
  // Of a temperature x^2: heat through the film of the slide's front, and between pad and rail.
  const mesh::MachineMesh& mesh = slide(2);
  const ThermalSystem& s = slide_system(2);
  Eigen::VectorXd on_slide = Eigen::VectorXd::Zero(s.size);
  for (Eigen::Index i = 0; i < mesh.bodies[1].nodes(); ++i) {
    const Eigen::Vector3d p = mesh.bodies[1].points.col(i);
    on_slide[mesh.first_node[1] + i] = p.y() * p.y();
  }
  const auto dissipated = [&](std::size_t t) { return on_slide.dot(s.terms[t] * on_slide); };
  const double y_to_the_fourth = (std::pow(0.11, 5) - std::pow(0.01, 5)) / 5.0;
  EXPECT_NEAR(dissipated(2), 0.059 * y_to_the_fourth, 1e-12 * dissipated(2));  // film of the front
  for (std::size_t t = 0; t < s.terms.size(); ++t) {
    if (s.layout.terms[t].kind == TermKind::contact && s.layout.terms[t].item == 0) {
      EXPECT_NEAR(dissipated(t), 0.1 * y_to_the_fourth, 1e-12 * dissipated(t)) << t;
    }
  }
}

TEST(ThermalSystem, RefusesAJointThatNeverTouches) {
  mesh::Machine machine = test::slide_machine();
  machine.joints[0].reach = 0.0005;
  EXPECT_THROW(assemble_thermal(test::slide_mesh(1, machine)), core::InputError);
}

TEST_P(ThermalSystemOfOrder, ShiftedSolvesAndTheirTransposes) {
  const ThermalSystem& s = slide_system(GetParam());
  Coefficients c;
  c.p = Eigen::VectorXd::LinSpaced(std::ssize(s.terms), 3.0, 40.0);
  c.q = Eigen::VectorXd::Zero(s.inputs.cols());
  SparseMatrix a = 0.01 * s.capacity + s.conduction;
  for (std::size_t t = 0; t < s.terms.size(); ++t) a += c.p[t] * s.terms[t];
  const Eigen::MatrixXd b = s.inputs;
  EXPECT_LT((a * solve_shifted(s, c, 0.01, b) - b).norm(), 1e-10 * b.norm());
  EXPECT_LT((a.transpose() * solve_shifted(s, c, 0.01, b, true) - b).norm(), 1e-10 * b.norm());
  EXPECT_GT((solve_shifted(s, c, 0.01, b) - solve_shifted(s, c, 0.01, b, true)).norm(), 0.0);
}

TEST_P(ThermalSystemOfOrder, AFloatingBodyHasNoSteadyState) {
  const ThermalSystem& s = slide_system(GetParam());
  Coefficients c;
  c.p = Eigen::VectorXd::Zero(std::ssize(s.terms));
  c.q = Eigen::VectorXd::Zero(s.inputs.cols());
  EXPECT_THROW(solve_steady(s, c), core::SolverError);
}

}  // namespace thermotwin::solver
