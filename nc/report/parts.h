// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A series of parts: mean and range of the offsets of each one's cutting moves, and the first good part.

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

#include "nc/prediction/prediction.h"

namespace thermotwin::nc {

struct Part {
  double start = 0, end = 0;  ///< s, of its cutting moves
  long moves = 0;
  double seconds = 0;
  Eigen::ArrayXd sum, low, high;  ///< (linear axes) um, of the offsets along them; sum over time
  Eigen::ArrayXd ahead;           ///< (linear axes) um, sum of what lies ahead; empty: not known
  Eigen::ArrayXd mean() const { return sum / seconds; }
};

class Parts {
public:
  void add(const PredictedMove& move);
  std::string csv(const std::vector<std::string>& axes) const;
  /// The first part whose mean offsets, and those of all after it, are within a tolerance of the last part's; from 1.
  int first_good(double within_um) const;
  /// Distance of the last part's mean offsets from those of an endless series, um, of the axis where it is largest
  /// (CycleDrift). Infinite where it is not known: for fewer than two parts.
  double drift_ahead() const;
  /// s, of the first cutting move. @param part  from 1
  double start_of(int part) const { return parts_.at(part - 1).start; }
  const std::map<int, Part>& all() const { return parts_; }  ///< by number, from 0

private:
  std::map<int, Part> parts_;
};

/// Says that a series is too short. @param unit  of both as the reader takes it: um or µm
std::string unsettled_text(double drift_ahead_um, double tolerance_um, const std::string& unit);

}  // namespace thermotwin::nc
