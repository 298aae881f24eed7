// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/residual_probes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <random>

#include "core/range.h"
#include "reduction/basis/responses.h"
#include "solver/linear/sparse_factor.h"

namespace thermotwin::reduction {
namespace {

constexpr double held_share = 1e-12;  ///< row sums below this share of the diagonal are rounding

/// Unknowns that entries of M connect: the smallest index of each one's part.
std::vector<int> connected_parts(const solver::SparseMatrix& m) {
  std::vector<int> part(m.rows());
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](int i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (int column = 0; column < m.outerSize(); ++column) {
    for (solver::SparseMatrix::InnerIterator entry(m, column); entry; ++entry) {
      if (entry.value() == 0.0) continue;
      const int a = root(entry.row()), b = root(column);
      part[std::max(a, b)] = std::min(a, b);
    }
  }
  for (int i = 0; i < std::ssize(part); ++i) part[i] = root(i);
  return part;
}

}  // namespace

double certain_share(Eigen::Index count, double failure) {
  const double wanted = 2.0 * std::log(failure) / count;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double s = 0.5 * (low + high);
    (std::log(s) + 1.0 - s < wanted ? low : high) = s;
  }
  return low;
}

solver::SparseMatrix least_conduction(const solver::ThermalSystem& thermal, const Eigen::VectorXd& least,
                                      Eigen::MatrixXd& loose_fields) {
  solver::SparseMatrix m = symmetric_conduction(thermal, least);
  m = solver::SparseMatrix(0.5 * (m + solver::SparseMatrix(m.transpose())));
  const std::vector<int> part = connected_parts(m);
  const Eigen::VectorXd outflow = m * Eigen::VectorXd::Ones(m.rows()), diagonal = m.diagonal();
  Eigen::VectorXd held = Eigen::VectorXd::Zero(m.rows()), stiffness = held;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    held(part[i]) += outflow(i);
    stiffness(part[i]) += diagonal(i);
  }
  const double typical = diagonal.sum() / m.rows();
  std::vector<int> loose;
  std::vector<Eigen::Triplet<double>> springs;
  for (int i = 0; i < m.rows(); ++i) {
    if (part[i] != i || held(i) > held_share * stiffness(i)) continue;
    loose.push_back(i);
    springs.emplace_back(i, i, typical > 0.0 ? typical : 1.0);
  }
  solver::SparseMatrix ground(m.rows(), m.cols());
  ground.setFromTriplets(springs.begin(), springs.end());
  m = solver::SparseMatrix(m + ground);
  m.makeCompressed();
  loose_fields = Eigen::MatrixXd::Zero(m.rows(), std::ssize(loose));
  for (std::size_t k = 0; k < loose.size(); ++k) {
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      if (part[i] == loose[k]) loose_fields(i, k) = 1.0;
  }
  return m;
}

void ProbeOptions::validate() const {
  core::require_option(count >= 0, "residual probes count", count, "0 (exact) or more");
  core::require_option(failure > 0.0 && failure < 1.0, "residual probes failure", failure, "above 0, below 1");
}

Eigen::MatrixXd residual_probes(const solver::SparseMatrix& m, const ProbeOptions& options) {
  options.validate();
  const solver::SparseFactor factor(m);
  if (options.count == 0) return factor.half_solve(Eigen::MatrixXd::Identity(m.rows(), m.rows()));
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd xi(m.rows(), options.count);
  for (double& value : xi.reshaped()) value = normal(random);
  return factor.half_solve(xi) / std::sqrt(options.count * certain_share(options.count, options.failure));
}

}  // namespace thermotwin::reduction
