// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The error of cutting moves over time: mean, range and deviation within intervals. If more than 800
// intervals are needed, pairs of them are merged.

#include <Eigen/Core>

#include <vector>

#include "nc/report/path_points.h"

namespace thermotwin::nc {

class ErrorOverTime {
public:
  struct Interval {
    long count = 0;
    Eigen::Array3d sum = Eigen::Array3d::Zero(), low = Eigen::Array3d::Zero(), high = Eigen::Array3d::Zero(),
                   std = Eigen::Array3d::Zero();  ///< um; std: the largest
    void add(const Interval& other);
  };
  void add(const PathPoint& point);
  double width() const { return width_; }  ///< s, of an interval
  const std::vector<Interval>& intervals() const { return intervals_; }

private:
  double width_ = 1.0;
  std::vector<Interval> intervals_;
};

}  // namespace thermotwin::nc
