// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/balanced_basis.h"

#include <Eigen/SVD>

#include <algorithm>

#include "reduction/systems/system_solver.h"

namespace thermotwin::reduction {
namespace {

constexpr double gramian_residual = 1e-10;  ///< of the low-rank iteration, relative

}  // namespace

Basis balanced_basis(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                     const std::vector<solver::OutputRows>& rows, Eigen::Index most) {
  const OperatingPoint rest = operating_points(model).front();
  StateSpace system;
  system.E = thermal.capacity;
  system.A = -symmetric_conduction(thermal, rest.c.p) - steady_shift * thermal.capacity;
  system.symmetric = true;
  system.B = effective_inputs(thermal, model, rest);
  system.C = observed_directions(thermal, rows).transpose();
  system.D = Eigen::MatrixXd::Zero(system.C.rows(), system.B.cols());

  SolverOptions options;
  options.residual = gramian_residual;
  const GramianFactors gramians = make_system_solver(system, "the machine at rest", options)->gramians();
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(gramians.core, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Index pairs = std::min(svd.singularValues().size(), (most + 1) / 2 + 20);
  const Eigen::MatrixXd reached = gramians.controllability * svd.matrixV().leftCols(pairs);
  const Eigen::MatrixXd observed = gramians.observability * svd.matrixU().leftCols(pairs);
  Eigen::MatrixXd directions(thermal.size, 1 + 2 * pairs);
  directions.col(0).setOnes();
  for (Eigen::Index k = 0; k < pairs; ++k) {
    directions.col(1 + 2 * k) = reached.col(k).normalized();
    directions.col(2 + 2 * k) = observed.col(k).normalized();
  }
  Basis basis;
  basis.singular_values = svd.singularValues();
  basis.vectors = orthonormal(thermal.capacity, directions);
  basis.rank = basis.vectors.cols();
  if (basis.vectors.cols() > most) basis.vectors = basis.vectors.leftCols(most).eval();
  return basis;
}

}  // namespace thermotwin::reduction
