// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/error_over_time.h"

#include <cmath>

namespace thermotwin::nc {

namespace {
constexpr std::size_t most_intervals = 800;
}

void ErrorOverTime::Interval::add(const Interval& other) {
  if (other.count == 0) return;
  if (count == 0) {
    *this = other;
    return;
  }
  count += other.count;
  sum += other.sum;
  low = low.min(other.low);
  high = high.max(other.high);
  std = std.max(other.std);
}

void ErrorOverTime::add(const PathPoint& point) {
  if (point.rapid) return;
  while (point.time >= width_ * most_intervals) {
    width_ *= 2.0;
    for (std::size_t i = 0; 2 * i < intervals_.size(); ++i) {
      Interval both = intervals_[2 * i];
      if (2 * i + 1 < intervals_.size()) both.add(intervals_[2 * i + 1]);
      intervals_[i] = both;
    }
    intervals_.resize((intervals_.size() + 1) / 2);
  }
  const auto at = static_cast<std::size_t>(point.time / width_);
  if (at >= intervals_.size()) intervals_.resize(at + 1);
  const Eigen::Array3d error = point.error_um.array();
  intervals_[at].add({1, error, error, error, point.std_um.array()});
}

}  // namespace thermotwin::nc
