// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A curve given by points.

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <span>

namespace thermotwin::core {

/// Linear between the points, constant beyond them. @param at  rises; one point or more  @param value  as many
inline double linear_at(std::span<const double> at, std::span<const double> value, double x) {
  if (x <= at.front()) return value.front();
  if (x >= at.back()) return value.back();
  const std::size_t right = std::upper_bound(at.begin(), at.end(), x) - at.begin();
  const double s = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return value[right - 1] + s * (value[right] - value[right - 1]);
}

inline double linear_at(const Eigen::VectorXd& at, const Eigen::VectorXd& value, double x) {
  return linear_at(std::span(at.data(), at.size()), std::span(value.data(), value.size()), x);
}

}  // namespace thermotwin::core
