// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/fit/plane_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "core/dense_algebra.h"
#include "core/error.h"

namespace thermotwin::metrology {

using core::InputError;

Plane fit_plane(const Eigen::MatrixX3d& points, const Eigen::Vector3d& towards, const std::string& place) {
  if (points.rows() < 3) throw InputError(place, fmt::format("{} points", points.rows()), "at least 3 points");
  if (!points.allFinite()) throw InputError(place, "a coordinate that is not finite", "finite numbers");
  Plane plane;
  plane.point = points.colwise().mean();
  const Eigen::MatrixXd about = points.rowwise() - plane.point.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spread(Eigen::MatrixXd(about.transpose() * about));
  if (!(spread.eigenvalues()[1] > 1e-20 * spread.eigenvalues()[2]))
    throw InputError(place, "points on a line", "points in a plane");
  plane.normal = spread.eigenvectors().col(0);
  if (plane.normal.dot(towards) < 0.0) plane.normal = -plane.normal;
  plane.rms = (about * plane.normal).norm() / std::sqrt(points.rows());
  return plane;
}

}  // namespace thermotwin::metrology
