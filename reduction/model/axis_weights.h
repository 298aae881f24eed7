// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Weights of positions of one axis at a place between them: along a linear axis by polynomials, between the angles of a
// swivel by sine and cosine. Beyond the ends they are those of the end.

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <vector>

namespace thermotwin::reduction {

/// By straight lines.
Eigen::VectorXd linear_weights(const std::vector<double>& positions, double x);

/// Quadratic through three positions.
Eigen::Vector3d quadratic_weights(const std::vector<double>& positions, double x);

/// Cubic through the four positions about x of more than three: the joints' pads make rows kink.
struct Cubic {
  std::size_t first = 0;
  std::array<double, 4> weights{};
};
Cubic cubic_weights(const std::vector<double>& positions, double x);

/// Angles of a swivel: by the cell's ends and the position before them (after them in the first cell), so that rows
/// are continuous; one or two positions by straight lines.
Eigen::VectorXd swivel_weights(const std::vector<double>& positions, double x, bool endless);

}  // namespace thermotwin::reduction
