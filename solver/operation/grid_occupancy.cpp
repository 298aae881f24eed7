// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/grid_occupancy.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace thermotwin::solver {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

/// Adds scale times the integrals over [a, b] of the two hat functions of the cell [left, right].
void add_cell(double left, double right, double a, double b, double scale, double& at_left, double& at_right) {
  const double length = right - left, width = b - a;
  const double to_right = width * (0.5 * (a + b) - left) / length;
  at_left += scale * (width - to_right);
  at_right += scale * to_right;
}

void linear_occupancy(const std::vector<double>& x, double low, double high, Eigen::Ref<Eigen::VectorXd> weights) {
  const auto n = std::ssize(x);
  const auto at = [&](Eigen::Index i) { return x[i]; };
  if (high - low <= 1e-12 * (1.0 + std::abs(low))) {
    const double p = std::clamp(low, at(0), at(n - 1));
    const Eigen::Index cell =
        std::clamp<Eigen::Index>(std::upper_bound(x.begin(), x.end(), p) - x.begin() - 1, 0, n - 2);
    const double s = (p - at(cell)) / (at(cell + 1) - at(cell));
    weights[cell] += 1.0 - s;
    weights[cell + 1] += s;
    return;
  }
  const double scale = 1.0 / (high - low);
  // Beyond the grid the matrices of its end stand.
  weights[0] += scale * std::max(0.0, std::min(high, at(0)) - low);
  weights[n - 1] += scale * std::max(0.0, high - std::max(low, at(n - 1)));
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const double a = std::max(low, at(i)), b = std::min(high, at(i + 1));
    if (b > a) add_cell(at(i), at(i + 1), a, b, scale, weights[i], weights[i + 1]);
  }
}

void periodic_occupancy(const std::vector<double>& x, double low, double high, Eigen::Ref<Eigen::VectorXd> weights) {
  const auto n = std::ssize(x);
  const auto at = [&](Eigen::Index i) { return x[i % n] + (i >= n ? turn * (i / n) : 0.0); };
  const double span = high - low;
  const double start = low - turn * std::floor((low - at(0)) / turn);  // in [x0, x0 + turn)
  if (span <= 1e-12 * turn) {
    for (Eigen::Index i = 0; i < n; ++i) {
      if (start > at(i + 1)) continue;
      const double s = std::max(0.0, (start - at(i)) / (at(i + 1) - at(i)));
      weights[i] += 1.0 - s;
      weights[(i + 1) % n] += s;
      return;
    }
    weights[0] += 1.0;
    return;
  }
  const double whole = std::floor(span / turn);
  for (Eigen::Index i = 0; whole > 0 && i < n; ++i)
    add_cell(at(i), at(i + 1), at(i), at(i + 1), whole / span, weights[i], weights[(i + 1) % n]);
  const double end = start + (span - whole * turn);
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const double a = std::max(start, at(i)), b = std::min(end, at(i + 1));
    if (b > a) add_cell(at(i), at(i + 1), a, b, 1.0 / span, weights[i % n], weights[(i + 1) % n]);
  }
}

}  // namespace

void grid_occupancy(const JointGrid& grid, double low, double high, Eigen::Ref<Eigen::VectorXd> weights) {
  weights.setZero();
  if (grid.positions.size() < 2) {
    weights.setOnes();
    return;
  }
  if (high < low) std::swap(low, high);
  if (grid.periodic)
    periodic_occupancy(grid.positions, low, high, weights);
  else
    linear_occupancy(grid.positions, low, high, weights);
}

Eigen::VectorXd grid_weights(const JointGrid& grid, double low, double high) {
  Eigen::VectorXd weights(std::ssize(grid.positions));
  grid_occupancy(grid, low, high, weights);
  return weights;
}

}  // namespace thermotwin::solver
