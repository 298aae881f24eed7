// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// First-order lag tau y' + y = u between the rows of a record, exact for an input that stands there, and for one
// that goes straight from row to row.

#include <Eigen/Core>

namespace thermotwin::core {

/// The lag over one interval.
class LagStep {
public:
  LagStep() = default;
  /// @param duration  s, not below 0  @param tau  s; not above 0: y is the input itself
  LagStep(double duration, double tau);

  /// y at the end. @param y  at the start  @param u  over the interval
  double standing(double y, double u) const { return u * rest_ + y * decay_; }
  /// y at the end. @param y  at the start  @param u0, u1  input at start and end
  double straight(double y, double u0, double u1) const {
    // In a form that does not cancel for a short interval.
    return duration_ > 0.0 ? u1 - (u1 - u0) / duration_ * tau_ * rest_ + (y - u0) * decay_ : y;
  }

private:
  double duration_ = 0.0, tau_ = 0.0, decay_ = 1.0, rest_ = 0.0;  ///< e^-x and 1 - e^-x, x = duration / tau
};

/// A series behind the lag, which starts in balance; straight lines between the points (n) each.
Eigen::VectorXd lagged_lines(const Eigen::VectorXd& time, const Eigen::VectorXd& values, double tau);

/// The same of a series whose values hold since the row before.
Eigen::VectorXd lagged_steps(const Eigen::VectorXd& time, const Eigen::VectorXd& values, double tau);

}  // namespace thermotwin::core
