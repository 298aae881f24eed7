// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/path_samples.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

constexpr double longest = 20.0 * units::mm, widest_arc = 6.0 * units::deg, widest_turn = 2.0 * units::deg;
constexpr double most_samples = 720.0;  ///< two turns of a rotary axis

int sample_count(const Move& move) {
  const Nine change = (move.to - move.from).cwiseAbs();
  double count = std::max({1.0, change.head<3>().norm() / longest, change.segment<3>(3).maxCoeff() / widest_turn});
  if (move.kind == MoveKind::arc) count = std::max(count, move.arc.angle / widest_arc);
  return static_cast<int>(std::ceil(std::min(count, most_samples) - 1e-9));
}

}  // namespace

void PathSamples::add(const PredictedMove& predicted) {
  const Element& element = predicted.timed->element;
  const Move& move = element.source->move;
  const int count = sample_count(move);
  PathPoint point;
  point.std_um = predicted.field->error_std(predicted.std_um);
  point.line = element.state.line;
  point.rapid = element.rapid;
  for (int k = first_ ? 0 : 1; k <= count; ++k) {
    const double u = 1.0 * k / count;
    const Positions positions = k == count ? predicted.end : motion_.positions(AxisMotion::values_at(move, u), move);
    point.place = motion_.tip(positions, move.tool_offset);
    point.time = k == count ? predicted.time : predicted.time_at(u);
    point.error_um = k == count
                         ? predicted.error_um
                         : Eigen::Vector3d(predicted.field->error(positions, point.time).error.head<3>() / units::um);
    take_(point, positions);
  }
  first_ = false;
}

}  // namespace thermotwin::nc
