// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time-weighted means of the channels over a thermal step. The pose of an axis that moves between
// rows becomes the range that it swept, since heat at a joint goes where the axis spends its time.
// A channel that stands keeps its exact value, so that equal steps stay equal to the last bit and
// the stepper can reuse its factors.

#include <Eigen/Core>

#include <vector>

#include "solver/operation/channels.h"

namespace thermotwin::compensation {

class InputMean {
public:
  InputMean(const mesh::Machine& machine, const solver::Channels& channels);

  /// The row held for the duration. @param row (channels)
  void add(const Eigen::VectorXd& row, double duration);
  double duration() const { return duration_; }
  /// Mean row of what was added since the last take(). @return valid until the next call
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
