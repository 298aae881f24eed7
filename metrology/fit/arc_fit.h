// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Position and orientation of an axis of rotation from points on an arc about it (Gebhardt 2014, 4.16 to 4.32): a plane
// through the points gives the direction of the axis, a circle in this plane a point on it. The centre is carried along
// the fitted axis to the plane through a stated point, so that it has no lever of the tilt; (4.24) turns about the
// origin of coordinates and so states the centre there.

#include <Eigen/Core>

#include <string>

#include "core/units.h"
#include "metrology/fit/circle_fit.h"

namespace thermotwin::metrology {

/// Frame of the nominal axis: x and y are normal to it, z is along it.
struct ArcFrame {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: x, y, z in the frame of the points; a rotation
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< m, on the nominal axis: where the position is stated

  /// @param direction  of the axis, unit @param x  about where its x is to point
  static ArcFrame about(const Eigen::Vector3d& direction, const Eigen::Vector3d& x, const Eigen::Vector3d& point);
};

struct ArcFit {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< m, of the axis at the stated point, along x and y
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();    ///< rad, of the axis about x and about y
  double along = 0;                                  ///< m, mean of the points along z
  double radius = 0;                                 ///< m
  double rms_plane = 0, rms_circle = 0;              ///< m
  double span = 0;                                   ///< rad, of the arc: a turn less the largest gap
};

/// Arcs below this span determine no axis. A hundredth of a degree is for the rounding of points.
inline constexpr double least_span = 10.0 * core::units::deg, span_rounding = 0.01 * core::units::deg;

/// @param points  (n x 3) m @throws InputError: too few points, points that are no arc, a span below `least`
ArcFit fit_arc(const Eigen::MatrixX3d& points, const ArcFrame& frame, CircleMethod method = CircleMethod::geometric,
               const std::string& place = "arc fit", double least = least_span);

}  // namespace thermotwin::metrology
