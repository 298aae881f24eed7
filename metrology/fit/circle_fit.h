// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Circles through points of a plane. Geometric: the least squares of the distances |p - c| - r, by Levenberg-Marquardt
// steps from Taubin's circle. Kasa: the least squares of x^2 + y^2 + s1 x + s2 y + s3 (Gebhardt 2014, 4.25), biased to
// small circles where the arc is short. Taubin (1991): the same under the mean square of the gradient as norm, nearly
// without that bias. All are the same for points that lie on a circle.

#include <Eigen/Core>

#include <string>

namespace thermotwin::metrology {

enum class CircleMethod { kasa, taubin, geometric };

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
  double rms = 0;  ///< root mean square of the distances of the points from the circle
  /// Covariance of (centre, radius) for a standard deviation of 1 of each point along the radius.
  Eigen::Matrix3d cofactor = Eigen::Matrix3d::Zero();
  bool converged = true;
};

/// @param points  (n x 2), any unit @param place  of the points, for messages
/// @throws InputError: fewer than three points, a value that is not finite, points on one place or on a line
Circle fit_circle(const Eigen::MatrixX2d& points, CircleMethod method = CircleMethod::geometric,
                  const std::string& place = "circle fit");

}  // namespace thermotwin::metrology
