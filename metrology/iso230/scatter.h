// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the scatter of values adds to their range. The extremes of n values lie further apart than those of the motion:
// by some five standard deviations of 97 values of a machine that stands still. The scatter is that of third
// differences of successive values, or the stated uncertainty where this is not clearly larger. The motion's course is
// the longest moving straight line that predicts a value from the others as well as the best one does. Draws of this
// course with scatter have ranges whose mean and standard deviation are those of the range of the record.

#include <Eigen/Core>

#include <vector>

namespace thermotwin::metrology {

/// @param values  NaN: missing @param stated  one standard deviation of a value
/// @return standard deviation of the part that differs from value to value; the stated one where fewer than five
///   sequences of four values at equal times show it
double scatter_of(const Eigen::VectorXd& time, const Eigen::VectorXd& values, double stated);

/// The course of the motion; fewer than eight values as they are.
Eigen::VectorXd smooth_course(const Eigen::VectorXd& values);

struct RangeOfMotion {
  double range = 0;   ///< of the values
  double motion = 0;  ///< less what the scatter adds, at least 0
  double std = 0;     ///< of the motion: of the draws, of the scatter, and sqrt(2) of the stated one that is no scatter
};

/// @param firsts  numbers of values from the first one on; 0: no range
std::vector<RangeOfMotion> ranges_of_motion(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& firsts,
                                            double scatter, double stated);

}  // namespace thermotwin::metrology
