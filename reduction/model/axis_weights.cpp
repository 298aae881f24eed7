// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/axis_weights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thermotwin::reduction {

namespace {

/// Exact for 1, cos and sin through three angles (trigonometric Lagrange polynomials): what stands still in the
/// machine turns in a swivel's own frame.
Eigen::Vector3d turning_weights(const std::array<double, 3>& at, double x) {
  const auto half = [](double angle) { return std::sin(0.5 * angle); };
  Eigen::Vector3d weights;
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = at[(i + 1) % 3], b = at[(i + 2) % 3];
    weights(i) = half(x - a) * half(x - b) / (half(at[i] - a) * half(at[i] - b));
  }
  return weights;
}

}  // namespace

Eigen::VectorXd linear_weights(const std::vector<double>& positions, double x) {
  const std::size_t n = positions.size();
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  const double inside = std::clamp(x, positions.front(), positions.back());
  std::size_t cell = 0;
  while (cell + 2 < n && inside > positions[cell + 1]) ++cell;
  if (n == 1) {
    weights(0) = 1.0;
    return weights;
  }
  const double share = (inside - positions[cell]) / (positions[cell + 1] - positions[cell]);
  weights(cell) = 1.0 - share;
  weights(cell + 1) = share;
  return weights;
}

Eigen::Vector3d quadratic_weights(const std::vector<double>& positions, double x) {
  const double a = positions[0], b = positions[1], c = positions[2];
  const double t = std::clamp(x, a, c);
  Eigen::Vector3d weights;
  weights << (t - b) * (t - c) / ((a - b) * (a - c)), (t - a) * (t - c) / ((b - a) * (b - c)),
      (t - a) * (t - b) / ((c - a) * (c - b));
  return weights;
}

Cubic cubic_weights(const std::vector<double>& positions, double x) {
  const std::size_t n = positions.size();
  const double t = std::clamp(x, positions.front(), positions.back());
  std::size_t cell = 0;
  while (cell + 2 < n && t > positions[cell + 1]) ++cell;
  Cubic cubic;
  cubic.first = std::min(cell == 0 ? 0 : cell - 1, n - 4);
  for (std::size_t i = 0; i < 4; ++i) {
    double product = 1.0;
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != i)
        product *= (t - positions[cubic.first + j]) / (positions[cubic.first + i] - positions[cubic.first + j]);
    }
    cubic.weights[i] = product;
  }
  return cubic;
}

Eigen::VectorXd swivel_weights(const std::vector<double>& positions, double x, bool endless) {
  constexpr double turn = 2.0 * std::numbers::pi;
  const std::size_t n = positions.size();
  if (n == 1) return Eigen::VectorXd::Ones(1);
  std::vector<double> closed = positions;
  if (endless) {
    x -= turn * std::floor((x - positions.front()) / turn);
    closed.push_back(positions.front() + turn);
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  if (n == 2) {
    const Eigen::VectorXd straight = linear_weights(closed, x);
    for (Eigen::Index i = 0; i < straight.size(); ++i) weights(i % 2) += straight(i);
    return weights;
  }
  const double t = std::clamp(x, closed.front(), closed.back());
  std::size_t cell = 0;
  while (cell + 2 < closed.size() && t > closed[cell + 1]) ++cell;
  const std::size_t third = cell > 0 ? cell - 1 : endless ? n - 1 : 2;
  const std::array<std::size_t, 3> at{cell % n, (cell + 1) % n, third};
  const Eigen::Vector3d shares = turning_weights({positions[at[0]], positions[at[1]], positions[at[2]]}, t);
  for (std::size_t i = 0; i < 3; ++i) weights(at[i]) = shares(i);
  return weights;
}

}  // namespace thermotwin::reduction
