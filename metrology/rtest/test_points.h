// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The points of a test and the weights by which the evaluation makes location errors of their deviations. The weights
// are rows of the pseudoinverse of analysis.h, with the columns of drift, harmonics and shift of the table, so a model
// of the machine predicts what the evaluation finds: the motion of the tool's side, and the share of component errors
// that the points do not distinguish from location errors. The errors are those at the time of the cycle; a drift that
// is not linear in time within it is not in the weights.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "metrology/rtest/analysis.h"

namespace thermotwin::metrology {

/// Positions of a point as the pose of a channel, rotary axes within a turn: "B=90,C=0,X=100".
std::string place_text(const RTestRecord& record, const RTestPoint& point);

struct TestPoints {
  std::vector<std::string> poses;
  Eigen::MatrixXd weights;      ///< (errors x 3 poses) um or um/m per um; NaN: not observable
  std::vector<bool> of_cycles;  ///< (cycles) whether a cycle has these points and weights
  bool too_many = false;        ///< a cycle has too many points for CycleResult::functional
  bool empty() const { return poses.empty(); }
};

/// The points that most cycles have. A cycle with more than most_poses of them is thinned: the weights of the points
/// between two that stay go to both, as in a linear interpolation along the path. Empty: fewer than half of the
/// cycles have the same points, or a cycle has too many for CycleResult::functional.
TestPoints common_points(const RTestRecord& record, const RTestAnalysis& analysis);
inline constexpr Eigen::Index most_poses = 60;

}  // namespace thermotwin::metrology
