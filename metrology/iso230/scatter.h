// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Corrects a range of values for their scatter. The extremes of n values lie further apart than those of the motion:
// for 97 values of a machine at rest, by some five standard deviations. The scatter is estimated from third differences
// of successive values; unless this is clearly less, the stated uncertainty is used. The motion's course is the longest
// moving straight line whose mean square leave-one-out error is within 5 % of the least. Random draws of this course
// with scatter give the excess of the range and its standard deviation.

#include <Eigen/Core>

#include <vector>

namespace thermotwin::metrology {

/// @param values  NaN: missing @param stated  one standard deviation of a value
/// @return standard deviation of the part that differs from value to value; the stated one unless the estimate,
///   from third divided differences of at least five sequences of four known values, is clearly smaller
double scatter_of(const Eigen::VectorXd& time, const Eigen::VectorXd& values, double stated);

/// The course of the motion; fewer than eight values as they are.
Eigen::VectorXd smooth_course(const Eigen::VectorXd& values);

struct RangeOfMotion {
  double range = 0;   ///< of the values
  double motion = 0;  ///< less what the scatter adds, at least 0
  double std = 0;     ///< of the motion: from draws, error of the scatter, and sqrt(2) of the other part of `stated`
};

/// @param firsts  numbers of values from the first one on; 0: no range
std::vector<RangeOfMotion> ranges_of_motion(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& firsts,
                                            double scatter, double stated);

}  // namespace thermotwin::metrology
