// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/fit/arc_fit.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/units.h"
#include "metrology/fit/plane_fit.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixX2d;
using Eigen::MatrixX3d;
using Eigen::Vector3d;

namespace {

double span_of(const MatrixX2d& points, const Eigen::Vector2d& centre) {
  std::vector<double> angles;
  for (Index i = 0; i < points.rows(); ++i)
    angles.push_back(std::atan2(points(i, 1) - centre[1], points(i, 0) - centre[0]));
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) gap = std::max(gap, angles[i] - angles[i - 1]);
  return 2.0 * std::numbers::pi - gap;
}

}  // namespace

ArcFrame ArcFrame::about(const Vector3d& direction, const Vector3d& x, const Vector3d& point) {
  ArcFrame frame;
  frame.point = point;
  const Vector3d across = x - direction * direction.dot(x);
  frame.axes.col(2) = direction;
  frame.axes.col(0) = (across.norm() > 1e-9 ? across : Vector3d(direction.unitOrthogonal())).normalized();
  frame.axes.col(1) = direction.cross(frame.axes.col(0));
  return frame;
}

ArcFit fit_arc(const MatrixX3d& points, const ArcFrame& frame, CircleMethod method, const std::string& place,
               double least) {
  const MatrixX3d local = (points.rowwise() - frame.point.transpose()) * frame.axes;
  const Plane plane = fit_plane(local, Vector3d::UnitZ(), place);
  if (plane.normal[2] < 0.5) {
    throw core::InputError(place, "points whose plane is not normal to the axis", "points on an arc about the axis");
  }
  // The smallest rotation that takes the normal to z, about the mean point.
  const Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(plane.normal, Vector3d::UnitZ()).toRotationMatrix();
  const MatrixX3d flat = (local.rowwise() - plane.point.transpose()) * turn.transpose();
  const Circle circle = fit_circle(flat.leftCols<2>(), method, place);
  ArcFit result;
  result.span = span_of(flat.leftCols<2>(), circle.centre);
  if (result.span < least - span_rounding) {
    throw core::InputError(place, fmt::format("an arc of {:.4g} deg", result.span / core::units::deg),
                           fmt::format("at least {:.3g} deg", least / core::units::deg));
  }
  const Vector3d centre = plane.point + turn.transpose() * Vector3d(circle.centre[0], circle.centre[1], 0.0);
  const Vector3d at_point = centre - plane.normal * (centre[2] / plane.normal[2]);
  result.centre = at_point.head<2>();
  result.tilt = {-std::atan2(plane.normal[1], plane.normal[2]), std::atan2(plane.normal[0], plane.normal[2])};
  result.along = local.col(2).mean();
  result.radius = circle.radius;
  result.rms_plane = plane.rms;
  result.rms_circle = circle.rms;
  return result;
}

}  // namespace thermotwin::metrology
