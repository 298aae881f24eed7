// SPDX-License-Identifier: GPL-3.0-or-later
// The dense and the sparse route: Gramians, responses, modes; both on the same systems.
#include "reduction/systems/system_solver.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/error.h"
#include "reduction/linear/lapack.h"
#include "tests/reduction/external_systems.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr SolverOptions sparse_route{0, 1e-13};

MatrixXcd solution(const MatrixXcd& matrix, const MatrixXcd& b) { return matrix.partialPivLu().solve(b); }

VectorXd hankel(const StateSpace& system, const SolverOptions& options = {}) {
  return lapack::svd(make_system_solver(system, "system", options)->gramians().core).values;
}

std::vector<LinearSystem> systems_of_all_kinds() {
  std::vector<LinearSystem> all;
  all.push_back(test::rod(60));
  all.push_back(test::plate(8, 3));
  all.push_back(test::plate(8, 2, 20.0));
  all.push_back(test::chain(20, true));
  all.push_back(test::chain(15, false));
  return all;
}

TEST(SystemSolver, OneStateHasTheKnownHankelValue) {
  const LinearSystem one = test::make_system(test::sparse(1, 1, {{0, 0, -2.0}}), MatrixXd::Constant(1, 1, 3.0),
                                             MatrixXd::Constant(1, 1, 5.0), true);
  EXPECT_DOUBLE_EQ(hankel(one.base)(0), 15.0 / 4.0);
  StateSpace general = one.base;
  general.symmetric = false;
  EXPECT_DOUBLE_EQ(hankel(general)(0), 15.0 / 4.0);
}

// With C = B^T and A symmetric the cross Gramian is P: the values sum up to half the gain at rest.
TEST(SystemSolver, ValuesOfASymmetricSystemSumToHalfItsStaticGain) {
  LinearSystem rod = test::rod(80);
  rod.base.C = rod.base.B.transpose();
  const double gain = solution(-MatrixXd(rod.base.A).cast<Complex>(), rod.base.B.cast<Complex>())(0).real();
  EXPECT_NEAR(hankel(rod.base).sum(), gain / 2, 5e-14 * gain);
  rod.base.symmetric = false;  // the general route on the same numbers
  EXPECT_NEAR(hankel(rod.base).sum(), gain / 2, 1e-10 * gain);
}

TEST(SystemSolver, FactorsSolveTheLyapunovEquations) {
  for (const LinearSystem& system : systems_of_all_kinds()) {
    const GramianFactors factors = make_system_solver(system.base, "system")->gramians();
    const MatrixXd e(system.base.E), a(system.base.A);
    const MatrixXd p = factors.controllability * factors.controllability.transpose(),
                   q = factors.observability * factors.observability.transpose();
    const MatrixXd of_p = a * p * e.transpose(), of_q = a.transpose() * q * e;
    EXPECT_LT((of_p + of_p.transpose() + system.base.B * system.base.B.transpose()).norm(), 1e-11 * of_p.norm())
        << a.rows();
    EXPECT_LT((of_q + of_q.transpose() + system.base.C.transpose() * system.base.C).norm(), 1e-11 * of_q.norm())
        << a.rows();
    EXPECT_LT((factors.core - factors.observability.transpose() * e * factors.controllability).norm(),
              1e-11 * factors.core.norm())
        << a.rows();
  }
}

TEST(SystemSolver, HankelValuesDoNotDependOnTheCoordinates) {
  const LinearSystem plain = test::plate(6, 2, 20.0);
  StateSpace scaled = plain.base;
  const Index n = scaled.size();
  std::mt19937 engine(3);
  VectorXd rows(n), columns(n);
  for (Index k = 0; k < n; ++k) {
    rows(k) = std::ldexp(1.0, static_cast<int>(engine() % 60) - 30);
    columns(k) = std::ldexp(1.0, static_cast<int>(engine() % 60) - 30);
  }
  scaled.E = rows.asDiagonal() * plain.base.E * columns.asDiagonal();
  scaled.A = rows.asDiagonal() * plain.base.A * columns.asDiagonal();
  scaled.B = rows.asDiagonal() * plain.base.B;
  scaled.C = plain.base.C * columns.asDiagonal();
  const VectorXd wanted = hankel(plain.base), found = hankel(scaled);
  EXPECT_LT((wanted - found).cwiseAbs().maxCoeff(), 1e-11 * wanted(0));
}

TEST(SystemSolver, SparseAndDenseRoutesAgree) {
  for (const LinearSystem& system : systems_of_all_kinds()) {
    const auto dense = make_system_solver(system.base, "system"),
               sparse = make_system_solver(system.base, "system", sparse_route);
    EXPECT_TRUE(dense->dense());
    EXPECT_FALSE(sparse->dense());
    const VectorXd wanted = lapack::svd(dense->gramians().core).values;
    const GramianFactors factors = sparse->gramians();
    EXPECT_LE(factors.residual, sparse_route.residual);
    const VectorXd found = lapack::svd(factors.core).values;
    double difference = 0, sum = 0;
    for (Index k = 0; k < std::max(wanted.size(), found.size()); ++k) {
      const double apart = std::abs((k < wanted.size() ? wanted(k) : 0.0) - (k < found.size() ? found(k) : 0.0));
      difference = std::max(difference, apart);
      sum += apart;
    }
    EXPECT_LT(difference, 1e-9 * wanted(0)) << system.base.size();
    if (factors.unknown_sum) {
      EXPECT_LE(sum, *factors.unknown_sum + 1e-13 * wanted(0)) << system.base.size();
    }
    for (const Complex s : {Complex(0, 0), Complex(0, 0.7), Complex(2, 3)}) {
      const MatrixXcd pencil = s * MatrixXd(system.base.E).cast<Complex>() - MatrixXd(system.base.A).cast<Complex>();
      const MatrixXcd b = system.base.B.cast<Complex>(), c = system.base.C.transpose().cast<Complex>() * Complex(1, 1);
      const MatrixXcd right = solution(pencil, b), left = solution(pencil.transpose(), c);
      for (const SystemSolver* solver : {dense.get(), sparse.get()}) {
        const auto both = solver->solve(s, b, c);
        EXPECT_LT((both.right - right).norm(), 1e-10 * right.norm());
        EXPECT_LT((both.left - left).norm(), 1e-10 * left.norm());
        EXPECT_LT((solver->response(s) - system.base.C * right).norm(), 1e-10 * right.norm() * system.base.C.norm());
      }
    }
  }
}

TEST(SystemSolver, ModesAreModes) {
  for (const LinearSystem& system : systems_of_all_kinds()) {
    for (const SolverOptions& options : {SolverOptions{}, sparse_route}) {
      const auto solver = make_system_solver(system.base, "system", options);
      const Modes modes = solver->dominant_modes(6);
      EXPECT_GE(modes.values.size(), 6);
      for (Index k = 0; k < modes.values.size(); ++k) {
        const MatrixXcd ax = system.base.A * modes.right.col(k), ex = system.base.E * modes.right.col(k);
        EXPECT_LT((ax - modes.values(k) * ex).norm(), 1e-7 * ax.norm());
        const MatrixXcd ya = system.base.A.transpose() * modes.left.col(k),
                        ye = system.base.E.transpose() * modes.left.col(k);
        EXPECT_LT((ya - modes.values(k) * ye).norm(), 1e-7 * ya.norm());
        EXPECT_LT(std::abs((modes.left.col(k).transpose() * ex)(0) - 1.0), 1e-8);
      }
    }
  }
}

std::string refusal(const StateSpace& system, const SolverOptions& options) {
  try {
    make_system_solver(system, "folder", options);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SystemSolver, UnstableSystemsAreRefusedWithTheEigenvalue) {
  for (const SolverOptions& options : {SolverOptions{}, sparse_route}) {
    StateSpace growing = test::rod(30).base;
    for (Index k = 0; k < 31; ++k) growing.A.coeffRef(k, k) += 8.0 / 30;
    EXPECT_NE(refusal(growing, options).find("folder: not stable: (A, E) has the eigenvalue "), std::string::npos)
        << refusal(growing, options);
    growing.symmetric = false;
    EXPECT_NE(refusal(growing, options).find("not stable"), std::string::npos);

    StateSpace floating = test::rod(30).base;
    floating.A.coeffRef(30, 30) += 1.0;
    EXPECT_NE(refusal(floating, options).find("not stable"), std::string::npos) << refusal(floating, options);

    StateSpace fluttering = test::chain(20, true).base;
    for (Index k = 0; k < 20; ++k) fluttering.A.coeffRef(20 + k, 20 + k) += 0.02;
    EXPECT_NE(refusal(fluttering, options).find(" i"), std::string::npos) << refusal(fluttering, options);
  }
}

TEST(SystemSolver, SingularEIsRefused) {
  for (const SolverOptions& options : {SolverOptions{}, sparse_route}) {
    StateSpace system = test::chain(10, true).base;
    system.E.coeffRef(3, 3) = 0.0;
    EXPECT_NE(refusal(system, options).find("folder/E.mtx: singular: 1 of its 20 rows are empty"), std::string::npos)
        << refusal(system, options);
    system.E.coeffRef(3, 3) = 1.0;
    system.E.coeffRef(4, 3) = 1.0;
    system.E.coeffRef(3, 4) = 1.0;
    EXPECT_NE(refusal(system, options).find("E.mtx: singular: reciprocal condition"), std::string::npos)
        << refusal(system, options);
  }
}

TEST(SystemSolver, StatesThatNothingDrivesAreNoTrouble) {
  StateSpace system = test::rod(20).base;
  system.B.conservativeResize(Eigen::NoChange, 2);
  system.B.col(1).setZero();
  EXPECT_LT((hankel(system).head(5) - hankel(test::rod(20).base).head(5)).norm(), 1e-14);
  const LinearSystem apart =
      test::make_system(test::sparse(3, 3, {{0, 0, -1.0}, {1, 1, -2.0}, {2, 2, -3.0}, {0, 1, 1.0}}),
                        (MatrixXd(3, 1) << 1, 0, 0).finished(), (MatrixXd(1, 3) << 1, 1, 1).finished());
  const VectorXd values = hankel(apart.base);
  EXPECT_NEAR(values(0), 0.5, 1e-15);
  EXPECT_LT(values(1), 1e-15);
}

}  // namespace
}  // namespace thermotwin::reduction
