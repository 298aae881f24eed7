// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What stands between a model and the axes of a machine: an offset has a largest size and a largest
// rate, starts from nought, and where the model fails or stops (a NaN) it stays for a while and then
// goes back to nought at that rate. So no offset ever jumps by more than rate x time between rows.
// Beside the rate, an offset may change by what the axes' motion since the last row accounts for (offset_limits.h).

#include <Eigen/Core>

namespace thermotwin::compensation {

struct GuardOptions {
  double largest_um = 200.0;
  double rate_um_s = 5.0;
  double hold_s = 60.0;   ///< without a valid offset, before going back
  void validate() const;  ///< @throws InputError
};

enum class GuardState { following, limited, holding, returning };

class OffsetGuard {
public:
  /// @throws InputError for options out of range
  OffsetGuard(Eigen::Index axes, const GuardOptions& options);

  /// @param time    s, rising  @param wanted_um  (axes) NaN in any: the model has failed
  /// @param motion_um  >= 0: change allowed beside rate x time since the last call
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
