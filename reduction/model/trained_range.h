// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The coefficients that a basis has seen.

#include <Eigen/Core>

#include <string>

namespace thermotwin::reduction {

/// Coefficients that the basis has seen: operating points and training loads; empty: unknown.
struct TrainedRange {
  Eigen::VectorXd low, high;  ///< (terms) p
  void include(const Eigen::VectorXd& p);
};

struct ReducedModel;

/// The coefficient that leaves the trained range most, where that is by more than a tenth of the
/// range's width: its item, values and range; empty: none.
std::string outside_trained(const ReducedModel& model, const TrainedRange& seen);

}  // namespace thermotwin::reduction
