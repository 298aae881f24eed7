// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Points of the tool's path with their TCP error. Two points of a predicted move are at most 20 mm, 6 deg of an arc and
// 2 deg of a rotary axis apart; a move has at most 720 intervals.

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

  /// @param move  its element must have a source (Element::source)
  void add(const PredictedMove& move);
  void restart() { first_ = true; }  ///< the next move gets a point at its beginning, as the first move does

private:
  const AxisMotion& motion_;
  Take take_;
  bool first_ = true;
};

}  // namespace thermotwin::nc
