// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the page of `nc` shows, collected along the program.

#include <optional>
#include <string>

#include "nc/motion/axis_motion.h"
#include "nc/report/beyond_limits.h"
#include "nc/report/error_over_time.h"
#include "nc/report/operations.h"
#include "nc/report/parts.h"
#include "nc/report/path_points.h"
#include "nc/report/path_samples.h"
#include "nc/report/report.h"

namespace thermotwin::tools {

class PageContent {
public:
  /// @param beyond  must outlive this
  PageContent(const nc::AxisMotion& motion, const nc::BeyondLimits& beyond);
  void add(const nc::PredictedMove& move);
  std::string page(nc::Report report, const nc::Operations& operations, const nc::Parts& parts);

private:
  nc::PathPoints path_;
  nc::ErrorOverTime errors_;
  const nc::BeyondLimits& beyond_;
  nc::PathSamples samples_;
  std::optional<nc::PathPoint> worst_before_;  ///< of the parts before the last one
  int worst_part_ = 0;
};

}  // namespace thermotwin::tools
