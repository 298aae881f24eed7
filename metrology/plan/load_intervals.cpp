// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/load_intervals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thermotwin::metrology {

namespace {

constexpr double turn_rad = 2.0 * std::numbers::pi;

/// Strokes from low to high and back until the time is over; the last one is as long as the rest allows.
void add_strokes(Timeline& timeline, const LoadMotion& load, double until) {
  mesh::Pose low = timeline.pose(), high = low;
  low[load.axis] = load.low;
  high[load.axis] = load.high;
  const double stroke = (load.high - load.low) / load.speed;
  timeline.rapid(low);
  while (until - timeline.now() > 1e-6) {
    const double left = until - timeline.now();
    mesh::Pose turning = high;
    if (left < 2.0 * stroke) turning[load.axis] = load.low + 0.5 * left * load.speed;
    if (turning[load.axis] - load.low < 1e-6) break;
    timeline.feed(turning, load.speed, load.speed);
    timeline.feed(low, load.speed, load.speed);
  }
}

}  // namespace

void add_load_interval(const mesh::Machine& machine, Timeline& timeline, const std::vector<LoadMotion>& loads,
                       double seconds, const std::string& name) {
  const double end = timeline.now() + seconds;
  std::vector<LoadMotion> moving;
  mesh::Pose held = timeline.pose();
  for (const LoadMotion& load : loads) {
    if (load.axis < 0) continue;
    const mesh::Axis& axis = machine.axes[load.axis];
    if (load.speed > 0 && (axis.endless || load.high > load.low)) {
      moving.push_back(load);
    } else if (!axis.endless) {
      held[load.axis] = load.low;
    }
  }
  if ((held - timeline.pose()).cwiseAbs().maxCoeff() > 1e-9) {
    timeline.begin_stage("way to " + name);
    timeline.rapid(held);
  }
  timeline.begin_stage(name);
  for (const LoadMotion& load : loads)
    if (load.axis < 0) timeline.spindle(load.speed);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const LoadMotion& load = moving[i];
    const double left = end - timeline.now(), share = left / (moving.size() - i);
    if (machine.axes[load.axis].endless) {
      timeline.turn(load.axis, static_cast<long>(std::floor(share * load.speed / turn_rad + 1e-9)), load.speed);
    } else {
      add_strokes(timeline, load, timeline.now() + share);
    }
  }
  timeline.dwell(end - timeline.now());
}

RandomLoads::RandomLoads(std::vector<Limits> limits, double change_probability, bool standstills, std::uint64_t seed)
    : limits_(std::move(limits)),
      change_probability_(change_probability),
      standstills_(standstills),
      engine_(seed) {}

double RandomLoads::uniform() { return (engine_() >> 11) * 0x1p-53; }

const std::vector<LoadMotion>& RandomLoads::next() {
  const bool first = loads_.empty();
  const bool changes = uniform() < change_probability_;
  if (!first && !changes) return loads_;
  const bool ran = std::any_of(loads_.begin(), loads_.end(), [](const LoadMotion& load) { return load.speed > 0; });
  std::vector<LoadMotion> drawn;
  for (const Limits& limit : limits_) {
    LoadMotion load = limit.widest;
    const double speed = limit.lowest + uniform() * (limit.highest - limit.lowest);
    const double a = uniform(), b = uniform(), stands = uniform();
    const double length = limit.widest.high - limit.widest.low;
    load.speed = standstills_ && ran ? 0.0 : speed;
    if (length > 0) {
      load.low = limit.widest.low + std::min(a, b) * length;
      load.high = limit.widest.low + std::max(a, b) * length;
      if (stands < 0.5 || load.speed == 0.0) load.high = load.low;
    }
    drawn.push_back(load);
  }
  loads_ = drawn;
  return loads_;
}

}  // namespace thermotwin::metrology
