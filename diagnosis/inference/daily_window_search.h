// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The part of the day in which a heat source that machine.toml does not have acts, where a record states the time of
// day. Triangles of time, two hours apart, are responded to once; their sums are windows of two to eighteen hours. All
// windows with all patches are compared, and the edges of the best one are then moved in steps of a quarter of an hour.

#include <Eigen/Core>

#include <optional>

#include "diagnosis/causes/daily_window.h"
#include "diagnosis/inference/patch_evidence.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"

namespace thermotwin::diagnosis {

struct DailySource {
  DailyWindow window;
  Eigen::VectorXd series;  ///< (steps) height of the window
  double log_share = 0;    ///< log of the window's share in the prior of all windows
};

/// @param hours  (steps) hours since a midnight; NaN: not stated   @param base  machine about which it is linear
/// @param heat   loads and weights (combinations x patches x shares)
/// @return nothing where no window describes the record better than no source
std::optional<DailySource> find_daily_source(const Problem& problem, const Response& response,
                                             const MachineInTime& base, const Eigen::VectorXd& hours,
                                             const Combinations& heat);

/// Sun and shifts have no straight lines: the course of their heat differs from a window in its edges and in its
/// roundness. @return (steps x 3) one standard deviation each
Eigen::MatrixXd course_freedom(const DailyWindow& window, const Eigen::VectorXd& hours);

}  // namespace thermotwin::diagnosis
