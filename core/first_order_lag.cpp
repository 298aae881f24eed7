// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/first_order_lag.h"

#include <cmath>

namespace thermotwin::core {

using Eigen::Index;
using Eigen::VectorXd;

LagStep::LagStep(double duration, double tau)
    : duration_(duration),
      tau_(tau > 0.0 ? tau : 0.0),
      decay_(tau > 0.0 ? std::exp(-duration / tau) : 0.0),
      rest_(tau > 0.0 ? -std::expm1(-duration / tau) : 1.0) {}

VectorXd lagged_lines(const VectorXd& time, const VectorXd& values, double tau) {
  VectorXd y = values;
  for (Index i = 1; tau > 0.0 && i < y.size(); ++i)
    y[i] = LagStep(time[i] - time[i - 1], tau).straight(y[i - 1], values[i - 1], values[i]);
  return y;
}

VectorXd lagged_steps(const VectorXd& time, const VectorXd& values, double tau) {
  VectorXd y = values;
  for (Index i = 1; tau > 0.0 && i < y.size(); ++i)
    y[i] = LagStep(time[i] - time[i - 1], tau).standing(y[i - 1], values[i]);
  return y;
}

}  // namespace thermotwin::core
