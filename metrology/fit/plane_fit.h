// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The plane through points by the least squares of their distances: through the mean, normal to the direction of the
// smallest spread. Unlike the form n.r = 1 of Gebhardt (2014, 4.17), it holds for planes through the origin.

#include <Eigen/Core>

#include <string>

namespace thermotwin::metrology {

struct Plane {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< mean of the points
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit
  double rms = 0;                                    ///< of the distances
};

/// @param points  (n x 3) @param towards  the normal has a positive component along it
/// @throws InputError: fewer than three points, a value that is not finite, points on a line
Plane fit_plane(const Eigen::MatrixX3d& points, const Eigen::Vector3d& towards, const std::string& place = "plane fit");

}  // namespace thermotwin::metrology
