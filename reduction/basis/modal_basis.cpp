// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/modal_basis.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <random>

#include "reduction/basis/responses.h"
#include "solver/operation/layout.h"
#include "solver/thermal/direct.h"

namespace thermotwin::reduction {
namespace {

constexpr double steps_a_mode = 2.5;  ///< of the Lanczos process, for converged modes
constexpr Eigen::Index more_steps = 50;
constexpr double invariant = 1e-12;

}  // namespace

Basis modal_basis(const solver::ThermalSystem& thermal, const Eigen::VectorXd& p, Eigen::Index most) {
  const Eigen::Index n = thermal.size;
  Eigen::VectorXd still = p;
  for (std::size_t j = 0; j < thermal.terms.size(); ++j)
    if (thermal.layout.terms[j].kind == solver::TermKind::coolant_flow) still(j) = 0.0;
  solver::ThermalDirectSolver inverse(thermal);
  inverse.factorise(still, steady_shift);

  const Eigen::Index steps = std::min(n, static_cast<Eigen::Index>(steps_a_mode * most) + more_steps);
  Eigen::MatrixXd q(n, steps);
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(steps), beside = Eigen::VectorXd::Zero(steps);
  std::mt19937 random(1);
  Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(
      n, [&](Eigen::Index) { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); });
  v /= std::sqrt(v.dot(thermal.capacity * v));
  Eigen::Index count = 0;
  for (; count < steps; ++count) {
    q.col(count) = v;
    const Eigen::VectorXd image = thermal.capacity * v;
    Eigen::VectorXd w = inverse.solve(image);
    diagonal(count) = w.dot(image);
    Eigen::VectorXd weighted;
    for (int pass = 0; pass < 2; ++pass) {  // twice is enough
      weighted = thermal.capacity * w;
      w.noalias() -= q.leftCols(count + 1) * (q.leftCols(count + 1).transpose() * weighted);
    }
    const double length = std::sqrt(std::max(0.0, w.dot(thermal.capacity * w)));
    if (length <= invariant * diagonal(0)) {
      ++count;
      break;
    }
    beside(count) = length;
    v = w / length;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
  eigen.computeFromTridiagonal(diagonal.head(count), beside.head(std::max<Eigen::Index>(0, count - 1)));

  Basis basis;
  basis.rank = std::min(count, most - 1);
  Eigen::MatrixXd directions(n, basis.rank + 1);
  directions.col(0).setOnes();
  directions.rightCols(basis.rank).noalias() =
      q.leftCols(count) * eigen.eigenvectors().rowwise().reverse().leftCols(basis.rank);
  basis.singular_values = eigen.eigenvalues().reverse().head(basis.rank);
  basis.vectors = orthonormal(thermal.capacity, directions);
  return basis;
}

}  // namespace thermotwin::reduction
