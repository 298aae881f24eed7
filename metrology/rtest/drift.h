// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The drift of a cycle of points from differences between visits of the same place. A place is the same within 0.5 deg
// of rotary axes and 3 mm of linear axes and of the nominal point, so that jitter of encoders hides no visit;
// in a sweep within a quarter of the mean step from point to point. Where visits are not exactly at one place, the
// differences that the estimated errors have between them are taken off.

#include <Eigen/Core>

#include <vector>

#include "core/units.h"
#include "metrology/rtest/error_terms.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

inline constexpr double same_angle = 0.5 * core::units::deg, same_length = 3.0 * core::units::mm;

struct Drift {
  /// (3 points x drifts) effect on each point, 0 in the middle of the cycle; first the common drift
  Eigen::MatrixXd columns;
  Eigen::MatrixXd inverse;  ///< (drifts x 3 points) of the deviations
  bool estimated() const { return columns.cols() > 0; }
};

/// A drift of all points alike, then of growth and rotations, then of the second order in time, those that the repeated
/// points distinguish. Differences between visits of one place alone count: what the place has of its own, such as a
/// component error of the axis, is in none of them.
/// @param rows  (3 points x parameters) of the fit, first those of the terms
Drift drift_of(const RTestRecord& record, const RTestCycle& cycle, const std::vector<ErrorTerm>& terms,
               const Eigen::MatrixXd& rows);

/// (points) time from -1/2 to 1/2 of the cycle
Eigen::VectorXd time_shares(const RTestCycle& cycle);

}  // namespace thermotwin::metrology
