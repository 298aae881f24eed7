// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Points of the tool's path with the error there: along each predicted move at most 20 mm, 6 deg of an arc and 2 deg of
// a rotary axis apart.

#include <functional>

#include "nc/motion/axis_motion.h"
#include "nc/prediction/prediction.h"
#include "nc/report/path_points.h"

namespace thermotwin::nc {

class PathSamples {
public:
  using Take = std::function<void(const PathPoint& point, const Positions& positions)>;

  /// @param motion  must outlive this
  PathSamples(const AxisMotion& motion, Take take) : motion_(motion), take_(std::move(take)) {}

  /// @param move  with the source of its element
  void add(const PredictedMove& move);
  void restart() { first_ = true; }  ///< the next move has a point at its begin, as the first one

private:
  const AxisMotion& motion_;
  Take take_;
  bool first_ = true;
};

}  // namespace thermotwin::nc
