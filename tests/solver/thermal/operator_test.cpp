// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/operator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include "solver/thermal/assembly.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

/// K0 + sum p K as written.
SparseMatrix conductance(const ThermalSystem& system, const Eigen::VectorXd& p) {
  SparseMatrix k = system.conduction;
  for (std::size_t t = 0; t < system.terms.size(); ++t) k += p[t] * system.terms[t];
  return k;
}

SideBySide numbers(Eigen::Index rows, Eigen::Index columns, double phase) {
  SideBySide m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = std::sin(0.37 * i + phase);
  return m;
}

}  // namespace

TEST(ThermalOperator, EachLoadHasItsOwnCoefficients) {
  const ThermalSystem system = assemble_thermal(test::slide_mesh());
  const ThermalOperator op(system);
  ASSERT_GT(op.fluids(), 0);
  for (const Eigen::Index loads : {1, 2, 3, 5, 8, 9, 12, 13, 30}) {
    SideBySide p = numbers(std::ssize(system.terms), loads, 0.2).cwiseAbs() * 40.0;
    p.row(1).setZero();  // a film that is off in all loads
    p(2, loads - 1) = 0.0;
    const SideBySide x = numbers(system.size, loads, 1.0);
    SideBySide ex, kx, stored, ax, alone, only;
    op.multiply(p, x, ex, kx);
    op.multiply_shifted(p, 3e-3, x, &stored, ax);
    op.multiply_shifted(p, 3e-3, x, nullptr, only);
    op.multiply_capacity(x, alone);
    for (Eigen::Index l = 0; l < loads; ++l) {
      const Eigen::VectorXd e = system.capacity * x.col(l), k = conductance(system, p.col(l)) * x.col(l),
                            a = 3e-3 * e + k;
      EXPECT_LT((ex.col(l) - e).norm(), 1e-13 * e.norm());
      EXPECT_LT((kx.col(l) - k).norm(), 1e-13 * k.norm());
      EXPECT_LT((stored.col(l) - e).norm(), 1e-13 * e.norm());
      EXPECT_LT((alone.col(l) - e).norm(), 1e-13 * e.norm());
      EXPECT_LT((ax.col(l) - a).norm(), 1e-13 * a.norm());
      EXPECT_LT((only.col(l) - a).norm(), 1e-13 * a.norm());
    }
  }
}

TEST(ThermalOperator, BlocksAreTheMatrixInParts) {
  const ThermalSystem system = assemble_thermal(test::slide_mesh());
  const ThermalOperator op(system);
  const Eigen::VectorXd p = numbers(std::ssize(system.terms), 1, 0.2).cwiseAbs() * 40.0;
  const Eigen::MatrixXd whole(SparseMatrix(2e-3 * system.capacity + conductance(system, p)));
  const Eigen::Index n = op.nodes(), f = op.fluids();
  SparseMatrix block;
  for (int again = 0; again < 2; ++again) {
    op.body_block(again ? p : 2.0 * p, 2e-3, block);
  }
  EXPECT_LT((Eigen::MatrixXd(block) - whole.topLeftCorner(n, n)).norm(), 1e-13 * whole.norm());
  EXPECT_LT((op.fluid_block(p, 2e-3) - whole.bottomRightCorner(f, f)).norm(),
            1e-13 * whole.bottomRightCorner(f, f).norm());
  const Eigen::MatrixXd coupling(op.coupling(p));
  EXPECT_LT((coupling.transpose() - whole.bottomLeftCorner(f, n)).norm(), 1e-13 * coupling.norm());
  EXPECT_LT((coupling - whole.topRightCorner(n, f)).norm(), 1e-13 * coupling.norm());
  // A solve by blocks is a solve with the whole.
  BlockSolver blocks;
  blocks.factorise(op, p, 2e-3);
  const SideBySide b = numbers(system.size, 3, 0.4);
  SideBySide x(b.rows(), b.cols());
  const std::vector<const BlockSolver::FluidFactor*> fluids(3, &blocks.own_fluid_factor());
  blocks.precondition(b, x, fluids);
  EXPECT_LT((whole * x - b).norm(), 1e-9 * b.norm());
}

}  // namespace thermotwin::solver
