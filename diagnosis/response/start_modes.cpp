// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/start_modes.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solver/operation/operating_model.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double least_start_s = 1800.0;
constexpr Index most_start_modes = 16;

}  // namespace

MatrixXd conduction_at_start(const reduction::ReducedModel& model, const mesh::Machine& machine,
                             const Observations& observations) {
  const solver::OperatingModel operating(machine, model.system.layout);
  const VectorXd p =
      operating.coefficients(observations.rows.row(0).transpose(), VectorXd::Zero(std::ssize(machine.coolants))).p;
  MatrixXd a = model.system.conduction;
  for (Index j = 0; j < p.size(); ++j)
    if (p[j] != 0.0) a += p[j] * model.system.terms[j];
  return 0.5 * (a + a.transpose());
}

MatrixXd start_modes(const reduction::ReducedModel& model, const mesh::Machine& machine,
                     const Observations& observations) {
  const reduction::ReducedSystem& system = model.system;
  if (observations.start_spread_K < even_start_K) return MatrixXd(system.order(), 0);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(conduction_at_start(model, machine, observations),
                                                                 system.capacity);
  Index count = 0;
  while (count < std::min(most_start_modes, system.order()) && eigen.eigenvalues()[count] * least_start_s < 1.0)
    ++count;
  return std::sqrt(system.one_kelvin.dot(system.capacity * system.one_kelvin)) * eigen.eigenvectors().leftCols(count);
}

}  // namespace thermotwin::diagnosis
