// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/residual_probes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <iterator>
#include <random>

#include "core/progress.h"
#include "reduction/basis/responses.h"
#include "reduction/model/reduced_model.h"
#include "reduction/model/trained_range.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Thermal {
  mesh::MachineMesh mesh = test::small_machine_mesh();
  solver::ThermalSystem system = solver::assemble_thermal(mesh);
  VectorXd least;

  Thermal() {
    const solver::OperatingModel operating(mesh.machine, system.layout);
    TrainedRange range;
    for (const OperatingPoint& point : operating_points(operating)) range.include(point.c.p);
    least = range.low;
  }
};

const Thermal& thermal() {
  static const Thermal made;
  return made;
}

VectorXd random_vector(std::mt19937& engine, Index size) {
  std::normal_distribution<double> normal;
  return VectorXd::NullaryExpr(size, [&](Index) { return normal(engine); });
}

TEST(ResidualProbes, AllOfThemGiveTheNormItself) {
  MatrixXd parts;
  const solver::SparseMatrix m = least_conduction(thermal().system, thermal().least, parts);
  const MatrixXd probes = residual_probes(m, {.count = 0});
  const Eigen::LDLT<MatrixXd> factor{MatrixXd(m)};
  std::mt19937 engine(1);
  for (int i = 0; i < 20; ++i) {
    const VectorXd r = random_vector(engine, m.rows());
    EXPECT_NEAR((probes.transpose() * r).squaredNorm(), r.dot(factor.solve(r)), 1e-8 * r.dot(factor.solve(r)));
  }
}

/// Seldom too small in 200 draws where one in a hundred may be, and on average by the factor that this costs.
TEST(ResidualProbes, FewOfThemSeeNoNormTooSmall) {
  MatrixXd parts;
  const solver::SparseMatrix m = least_conduction(thermal().system, thermal().least, parts);
  const Eigen::LDLT<MatrixXd> factor{MatrixXd(m)};
  std::mt19937 engine(2);
  int below = 0;
  double mean = 0.0;
  constexpr int draws = 200;
  constexpr double failure = 0.01;
  constexpr Index count = 40;
  for (int i = 0; i < draws; ++i) {
    const VectorXd r = random_vector(engine, m.rows());
    const MatrixXd probes = residual_probes(m, {count, failure, static_cast<std::uint64_t>(i + 1)});
    const double ratio = (probes.transpose() * r).squaredNorm() / r.dot(factor.solve(r));
    below += ratio < 1.0;
    mean += ratio / draws;
  }
  EXPECT_LE(below, static_cast<int>(2 * failure * draws));
  EXPECT_NEAR(mean, 1.0 / certain_share(count, failure), 0.05 * mean);
}

TEST(ResidualProbes, ShareIsChernoffs) {
  for (const Index count : {10, 100, 400}) {
    const double s = certain_share(count, 1e-6);
    EXPECT_NEAR(0.5 * count * (std::log(s) + 1.0 - s), std::log(1e-6), 1e-9);
    EXPECT_LT(s, 1.0);
  }
}

/// M is K at the least coefficients but for springs of parts that nothing holds, and below K(p) beside them.
TEST(ResidualProbes, LeastConductionIsBelowAll) {
  const solver::ThermalSystem& system = thermal().system;
  // Nothing is sure to touch: each body and each fluid node is a part of its own.
  const VectorXd least = VectorXd::Zero(thermal().least.size());
  MatrixXd parts;
  const MatrixXd m = least_conduction(system, least, parts);
  EXPECT_EQ(parts.cols(), std::ssize(thermal().mesh.machine.bodies) + system.size - system.nodes);
  const auto at = [&](const VectorXd& p) {
    MatrixXd k = system.conduction;
    for (Index j = 0; j < p.size(); ++j) k += p(j) * MatrixXd(system.terms[j]);
    return MatrixXd(0.5 * (k + k.transpose()));
  };
  const MatrixXd held = at(least), springs = m - held;
  EXPECT_EQ((springs.array().abs() > 1e-12 * m.norm()).count(), parts.cols());
  EXPECT_LT((held * parts).norm(), 1e-10 * held.norm());
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 5; ++i) {
    VectorXd p = thermal().least;
    for (double& value : p) value += 200.0 * unit(engine);
    VectorXd symmetric = thermal().least;
    for (Index j = 0; j < p.size(); ++j)
      if (system.layout.terms[j].kind == solver::TermKind::coolant_flow) symmetric(j) = 0.0;
    const VectorXd values =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(at(p) - at(symmetric), Eigen::EigenvaluesOnly).eigenvalues();
    EXPECT_GT(values(0), -1e-9 * values(values.size() - 1));
  }
}

}  // namespace
}  // namespace thermotwin::reduction
