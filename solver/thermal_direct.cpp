// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal_direct.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/thread_pool.h"
#include "solver/thermal_operator.h"

namespace thermotwin::solver {

struct ThermalDirectSolver::Impl {
  explicit Impl(const ThermalSystem& system) : op(system) {}
  ThermalOperator op;
  BlockSolver blocks;
  Eigen::VectorXd k_values;
};

ThermalDirectSolver::ThermalDirectSolver(const ThermalSystem& system) : impl_(std::make_unique<Impl>(system)) {}
ThermalDirectSolver::~ThermalDirectSolver() = default;
ThermalDirectSolver::ThermalDirectSolver(ThermalDirectSolver&&) noexcept = default;

void ThermalDirectSolver::factorise(const Eigen::VectorXd& p, double shift) {
  impl_->op.combine(p, impl_->k_values);
  impl_->blocks.factorise(impl_->op, impl_->k_values, shift);
  // A body that floats leaves a last pivot of rounding errors.
  const double rcond = impl_->blocks.factor().rcond();
  if (shift == 0.0 && rcond < 1e-13)
    throw core::SolverError(fmt::format(
        "steady state: the conduction matrix is singular (pivot ratio {:.1e}); a body has no path to any ambient", rcond));
}

Eigen::MatrixXd ThermalDirectSolver::solve(const Eigen::MatrixXd& right_hand_side, bool transpose) const {
  const BlockSolver& blocks = impl_->blocks;
  Eigen::MatrixXd x(right_hand_side.rows(), right_hand_side.cols());
  blocks.solve_bodies(right_hand_side, x);
  core::parallel_for(0, static_cast<std::size_t>(x.cols()), [&](std::size_t j) {
    blocks.finish(x.col(static_cast<Eigen::Index>(j)), blocks.own_fluid_factor(), transpose);
  });
  return x;
}

double ThermalDirectSolver::memory_bytes() const { return impl_->blocks.factor().memory_bytes(); }

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
