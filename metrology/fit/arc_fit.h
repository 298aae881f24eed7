// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Position and orientation of an axis of rotation from points on an arc about it (Gebhardt 2014, 4.16 to 4.32): a plane
// through the points gives the direction of the axis, a circle in this plane a point on it. The centre is moved along
// the fitted axis to the plane through a stated point, so it does not contain the tilt times the distance between this
// plane and the plane of the arc. (4.24) rotates about the origin of coordinates; its centre is that at the origin.

#include <Eigen/Core>

#include <string>

#include "core/units.h"
#include "metrology/fit/circle_fit.h"

namespace thermotwin::metrology {

/// Frame of the nominal axis: x and y are normal to it, z is along it.
struct ArcFrame {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: x, y, z in the frame of the points; a rotation
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< m, on the nominal axis: where the position is stated

  /// @param direction  of the axis, unit vector
  /// @param x          approximate direction of the frame's x; its part normal to the axis is used
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

/// An arc below least_span is refused, because it hardly determines an axis. span_rounding allows for rounded points.
inline constexpr double least_span = 10.0 * core::units::deg, span_rounding = 0.01 * core::units::deg;

/// @param points  (n x 3) m @throws InputError: too few points, points that are no arc, a span below `least`
ArcFit fit_arc(const Eigen::MatrixX3d& points, const ArcFrame& frame, CircleMethod method = CircleMethod::geometric,
               const std::string& place = "arc fit", double least = least_span);

}  // namespace thermotwin::metrology
