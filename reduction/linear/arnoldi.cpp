// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/arnoldi.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/progress.h"

namespace thermotwin::reduction {

using Eigen::Index;

ArnoldiPairs arnoldi(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& apply, Eigen::VectorXd start,
                     Index steps, double accuracy) {
  const Index n = start.size();
  steps = std::min(steps, n);
  Eigen::MatrixXd basis(n, steps + 1), h = Eigen::MatrixXd::Zero(steps + 1, steps);
  basis.col(0) = start / start.norm();
  Index size = 0;
  while (size < steps) {
    core::check_interrupt();
    Eigen::VectorXd next = apply(basis.col(size));
    const double before = next.norm();
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd along = basis.leftCols(size + 1).transpose() * next;
      next.noalias() -= basis.leftCols(size + 1) * along;
      h.col(size).head(size + 1) += along;
    }
    const double length = next.norm();
    ++size;
    constexpr double exhausted = 1e-14;
    if (length <= exhausted * before) break;
    h(size, size - 1) = length;
    basis.col(size) = next / length;
  }
  const double beyond = size < steps ? 0.0 : h(steps, steps - 1);
  const Eigen::EigenSolver<Eigen::MatrixXd> ritz(Eigen::MatrixXd(h.topLeftCorner(size, size)));
  const Eigen::MatrixXcd vectors = ritz.eigenvectors();
  std::vector<Index> good;
  for (Index k = 0; k < size; ++k) {
    if (beyond * std::abs(vectors(size - 1, k)) <= accuracy * std::abs(ritz.eigenvalues()(k))) good.push_back(k);
  }
  std::stable_sort(good.begin(), good.end(),
                   [&](Index a, Index b) { return std::abs(ritz.eigenvalues()(a)) > std::abs(ritz.eigenvalues()(b)); });
  ArnoldiPairs pairs{Eigen::VectorXcd(good.size()), Eigen::MatrixXcd(n, good.size())};
  for (std::size_t k = 0; k < good.size(); ++k) {
    pairs.values(k) = ritz.eigenvalues()(good[k]);
    const Eigen::VectorXcd y = vectors.col(good[k]);
    Eigen::VectorXcd x(n);
    x.real() = basis.leftCols(size) * y.real();
    x.imag() = basis.leftCols(size) * y.imag();
    pairs.vectors.col(k) = x / x.norm();
  }
  return pairs;
}

}  // namespace thermotwin::reduction
