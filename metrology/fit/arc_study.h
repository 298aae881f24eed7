// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Uncertainty of an axis fitted to an arc (Gebhardt 2014, 4.40 to 4.45, Figs. 4.15 to 4.17), by Monte Carlo simulation
// of continuous R-Tests and by linear least squares. The points have independent uniform errors in each direction.
// Along is the direction of the arc's bisector, across is normal to it in the plane of the arc. To first order, centre
// and radius have the rows (cos, sin, 1), and a tilt has these rows times the radius.

#include <Eigen/Core>

#include <cstdint>

#include "metrology/fit/circle_fit.h"

namespace thermotwin::metrology {

struct ArcStudy {
  double span = 0;           ///< rad, of the arc
  double radius = 0.19;      ///< m
  double half_width = 3e-6;  ///< m, of the uniform error of each coordinate
  double rate = 100;         ///< Hz
  double feed = 0;           ///< rad/s; 0: 600 deg/min
  double plane_offset = 0;   ///< m, from the stated point to the plane of the arc along the axis
  int draws = 4000;
  std::uint64_t seed = 1;
  CircleMethod method = CircleMethod::geometric;
  /// @throws InputError
  void validate() const;
};

struct ArcStudyResult {
  /// (draws x 4): centre along and across the bisector at the stated point, m; slope of the plane along and across it,
  /// rad; the axis tilts by the same angle in the opposite direction
  Eigen::MatrixX4d draws;
  Eigen::Vector4d std, range;  ///< of the draws
  Eigen::Vector4d theory;      ///< standard deviations of the linear least squares, at the stated point
  Eigen::Index points = 0;     ///< of one arc (4.15)
};

ArcStudyResult study_arc(const ArcStudy& study);

}  // namespace thermotwin::metrology
