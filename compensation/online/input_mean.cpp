// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/input_mean.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::compensation {

using Eigen::Index;

InputMean::InputMean(const mesh::Machine& machine, const solver::Channels& channels) {
  for (const mesh::Axis& axis : machine.axes) {
    const std::string id = "axis." + axis.id + ".", unit = axis.kind == mesh::AxisKind::linear ? "mm" : "deg";
    axes_.push_back({channels.index(id + "position_" + unit), channels.index(id + "low_" + unit),
                     channels.index(id + "high_" + unit), 0.0, 0.0});
  }
  first_ = sum_ = weight_ = mean_ = Eigen::VectorXd::Zero(channels.size());
  changed_.setConstant(channels.size(), false);
}

void InputMean::add(const Eigen::VectorXd& row, double duration) {
  const bool begins = duration_ == 0.0;
  if (begins) {
    first_ = row;
    sum_.setZero();
    weight_.setZero();
    changed_.setConstant(false);
  }
  duration_ += duration;
  for (Index k = 0; k < row.size(); ++k) {
    const double value = row[k];
    if (std::isnan(value)) {
      changed_[k] = changed_[k] || !std::isnan(first_[k]);
      continue;
    }
    changed_[k] = changed_[k] || !(value == first_[k]);
    sum_[k] += duration * value;
    weight_[k] += duration;
  }
  for (AxisRange& axis : axes_) {
    const double position = row[axis.position];
    const bool ranged = std::isfinite(row[axis.low]) && std::isfinite(row[axis.high]);
    const double low = ranged ? row[axis.low] : position, high = ranged ? row[axis.high] : position;
    axis.least = begins ? low : std::min(axis.least, low);
    axis.most = begins ? high : std::max(axis.most, high);
  }
}

const Eigen::VectorXd& InputMean::take() {
  mean_ = first_;
  for (Index k = 0; k < mean_.size(); ++k) {
    if (changed_[k] && weight_[k] > 0.0) mean_[k] = sum_[k] / weight_[k];
  }
  for (const AxisRange& axis : axes_) {
    if (axis.most > axis.least) {
      mean_[axis.low] = axis.least;
      mean_[axis.high] = axis.most;
    }
  }
  duration_ = 0.0;
  return mean_;
}

}  // namespace thermotwin::compensation
