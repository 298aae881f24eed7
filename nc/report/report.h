// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// report.html of `nc`: duration and largest TCP errors of the program, the operations of each tool, the moves beyond
// limits, and the drift over a series of parts.

#include <optional>
#include <string>
#include <vector>

#include "core/html_page.h"
#include "nc/report/beyond_limits.h"
#include "nc/report/error_over_time.h"
#include "nc/report/operations.h"
#include "nc/report/parts.h"
#include "nc/report/path_points.h"

namespace thermotwin::nc {

struct Report {
  std::string program, machine;
  std::string begins;             ///< thermal state at the start, in words
  std::vector<std::string> axes;  ///< linear axes with offsets
  double duration_s = 0, cutting_s = 0, rapid_s = 0, pause_s = 0;
  long moves = 0, lines = 0;
  int parts = 1, first_good_part = 0;                          ///< first_good_part 0: there is one part only
  double warm_up_s = 0, tolerance_um = 0, drift_ahead_um = 0;  ///< of a series; see Parts
  /// End of the cut with the largest error in the parts before the last one; only the last one's path is drawn.
  std::optional<PathPoint> worst_before;
  int worst_part = 0;     ///< part of worst_before, from 1
  std::string rewritten;  ///< words for the corrected program; empty: none
  std::string imprint;    ///< section of the finishing pass; empty: none
  std::string locations;  ///< section of the location errors
  std::vector<core::NextStep> next;
};

/// A picture of its own: mean offsets of each part and their range, with the first good part.
/// @param report  axes and the values of the series
std::string parts_svg(const Parts& parts, const Report& report);

/// @return a page of at most 3 MB
std::string report_page(const Report& report, const PathPoints& path, const ErrorOverTime& errors,
                        const Operations& operations, const BeyondLimits& beyond, const Parts& parts);

}  // namespace thermotwin::nc
