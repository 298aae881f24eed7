// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time-weighted means of the channels over a thermal step. The position of an axis that moves between rows becomes the
// range that it swept, because the heat of a joint is spread over the positions of the axis. A constant channel keeps
// its exact value, so that equal steps have equal bits and the stepper reuses its factors.

#include <Eigen/Core>

#include <vector>

#include "solver/operation/channels.h"

namespace thermotwin::compensation {

class InputMean {
public:
  InputMean(const mesh::Machine& machine, const solver::Channels& channels);

  /// Adds a row that holds for the duration. @param row  (channels)
  void add(const Eigen::VectorXd& row, double duration);
  double duration() const { return duration_; }
  /// @return the mean row since the last take(), valid until the next call
  const Eigen::VectorXd& take();

private:
  struct AxisRange {
    int position, low, high;
    double least, most;
  };
  std::vector<AxisRange> axes_;
  Eigen::VectorXd first_, sum_, weight_, mean_;
  Eigen::Array<bool, Eigen::Dynamic, 1> changed_;
  double duration_ = 0;
};

}  // namespace thermotwin::compensation
