// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/offset_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/range.h"

namespace thermotwin::compensation {

void GuardOptions::validate() const {
  core::require_within("offset guard largest_um", largest_um, {0.0, 1e5});
  core::require_within("offset guard rate_um_s", rate_um_s, {1e-6, 1e6});
  core::require_within("offset guard hold_s", hold_s, {0.0, 1e6});
}

OffsetGuard::OffsetGuard(Eigen::Index axes, const GuardOptions& options)
    : options_(options),
      applied_(Eigen::VectorXd::Zero(axes)),
      last_(applied_),
      time_(std::numeric_limits<double>::quiet_NaN()) {
  options.validate();
}

const Eigen::VectorXd& OffsetGuard::step(double time, const Eigen::VectorXd& wanted_um, double motion_um) {
  const double duration = std::isnan(time_) ? 0.0 : std::max(0.0, time - time_);
  const bool first = std::isnan(time_);
  time_ = time;
  const bool valid = wanted_um.allFinite();
  if (valid) {
    valid_at_ = time;
    last_ = wanted_um;
  } else if (first || time - valid_at_ > options_.hold_s) {
    last_.setZero();
  }
  bool limited = false;
  const double reach = options_.rate_um_s * duration + (first ? 0.0 : motion_um);
  for (Eigen::Index i = 0; i < applied_.size(); ++i) {
    const double allowed = std::clamp(last_[i], -options_.largest_um, options_.largest_um);
    const double next = std::clamp(allowed, applied_[i] - reach, applied_[i] + reach);
    limited = limited || next != last_[i];
    applied_[i] = next;
  }
  if (valid)
    state_ = limited ? GuardState::limited : GuardState::following;
  else
    state_ = !first && time - valid_at_ <= options_.hold_s ? GuardState::holding : GuardState::returning;
  return applied_;
}

}  // namespace thermotwin::compensation
