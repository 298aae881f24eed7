// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Guards the axes of a machine against a failing model. Size and rate of each offset are limited, and it starts from 0.
// If the model fails or stops (NaN), the offset is held for a while and then returns to 0 at that rate. Between two
// rows an offset therefore changes by at most rate x time, plus the change that the motion of the axes accounts for
// (offset_limits.h).

#include <Eigen/Core>

namespace thermotwin::compensation {

struct GuardOptions {
  double largest_um = 200.0;
  double rate_um_s = 5.0;
  double hold_s = 60.0;   ///< time of holding without a valid offset
  void validate() const;  ///< @throws InputError
};

enum class GuardState { following, limited, holding, returning };

class OffsetGuard {
public:
  /// @throws InputError for options out of range
  OffsetGuard(Eigen::Index axes, const GuardOptions& options);

  /// @param time    s, rising  @param wanted_um  (axes) NaN in any: the model has failed
  /// @param motion_um  >= 0: change allowed in addition to rate x time since the last call
  /// @return (axes) um to apply; valid until the next call
  const Eigen::VectorXd& step(double time, const Eigen::VectorXd& wanted_um, double motion_um = 0.0);
  GuardState state() const { return state_; }

private:
  GuardOptions options_;
  Eigen::VectorXd applied_, last_;
  double time_, valid_at_ = 0;
  GuardState state_ = GuardState::returning;
};

}  // namespace thermotwin::compensation
