// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The range of coefficients that a basis was trained on.

#include <Eigen/Core>

#include <string>

namespace thermotwin::reduction {

/// Range of the coefficients over operating points and training loads; empty: unknown.
struct TrainedRange {
  Eigen::VectorXd low, high;  ///< (terms) p
  void include(const Eigen::VectorXd& p);
};

struct ReducedModel;

/// @return item, value and range of the coefficient that exceeds its trained range most; empty if none exceeds it by
///   more than a tenth of its width
std::string outside_trained(const ReducedModel& model, const TrainedRange& seen);

}  // namespace thermotwin::reduction
