// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/direct.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/error.h"
#include "core/thread_pool.h"
#include "solver/thermal/integrator.h"
#include "solver/thermal/memory_plan.h"
#include "solver/thermal/operator.h"

namespace thermotwin::solver {

struct ThermalDirectSolver::Impl {
  explicit Impl(const ThermalSystem& system) : op(system) {}
  ThermalOperator op;
  BlockSolver blocks;
};

ThermalDirectSolver::ThermalDirectSolver(const ThermalSystem& system) : impl_(std::make_unique<Impl>(system)) {}
ThermalDirectSolver::~ThermalDirectSolver() = default;
ThermalDirectSolver::ThermalDirectSolver(ThermalDirectSolver&&) noexcept = default;

void ThermalDirectSolver::factorise(const Eigen::VectorXd& p, double shift) {
  impl_->blocks.factorise(impl_->op, p, shift);
  // A body that floats leaves a last pivot of rounding errors.
  const double rcond = impl_->blocks.factor().rcond();
  if (shift == 0.0 && rcond < 1e-13) {
    throw core::SolverError(fmt::format(
        "steady state: the conduction matrix is singular (pivot ratio {:.1e}); a body has no path to any ambient",
        rcond));
  }
}

Eigen::MatrixXd ThermalDirectSolver::solve(const Eigen::MatrixXd& right_hand_side, bool transpose) const {
  const BlockSolver& blocks = impl_->blocks;
  Eigen::MatrixXd x(right_hand_side.rows(), right_hand_side.cols());
  blocks.solve_bodies(right_hand_side, x);
  core::parallel_for(0, x.cols(),
                     [&](std::size_t j) { blocks.finish(x.col(j), blocks.own_fluid_factor(), transpose); });
  return x;
}

double ThermalDirectSolver::memory_bytes() const { return impl_->blocks.factor().memory_bytes(); }

MemoryNeed heat_memory_need(const ThermalSystem& system, SolverChoice choice, bool& wide) {
  const ThermalOperator op(system);
  SparseMatrix block;
  op.body_block(Eigen::VectorXd::Ones(std::ssize(system.terms)), 1.0, block);
  const double n = system.size, matrix = 12.0 * block.nonZeros();
  MemoryNeed need;
  if (choice != SolverChoice::iterative) {
    const SparseAnalysis analysis = analyse(block);
    need.factors = analysis.factor_bytes;
    need.work = analysis.work_bytes;
    wide = wide || analysis.wide;
  }
  // Levels, transfers, working blocks; the operator; a dozen loads side by side with ten vectors and
  // six directions each; walls of the fluid nodes; factors beyond the first.
  need.iterative = 2.0 * matrix;
  need.other = 5.0 * matrix + 12.0 * (10.0 + 2.0 * 6.0) * 8.0 * n + 2.0 * 8.0 * n * op.fluids();
  need.other += std::min(IntegratorOptions{}.factor_memory, 23.0 * std::max(need.factors, need.iterative));
  return need;
}

Eigen::VectorXd solve_steady(const ThermalSystem& system, const Coefficients& c) {
  return solve_shifted(system, c, 0.0, system.inputs * c.q);
}

Eigen::MatrixXd solve_shifted(const ThermalSystem& system, const Coefficients& c, double shift,
                              const Eigen::MatrixXd& right_hand_side, bool transpose) {
  ThermalDirectSolver solver(system);
  solver.factorise(c.p, shift);
  return solver.solve(right_hand_side, transpose);
}

}  // namespace thermotwin::solver
