// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/planner.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thermotwin::nc {

namespace {
constexpr double sharp = 0.87;  ///< tangent of half the angle, from which on an overlap is faster than a circle
}

double TimeCourse::share_at(double seconds) const {
  if (!(length > 0.0) || seconds >= duration()) return 1.0;
  if (seconds <= 0.0) return 0.0;
  double s = 0.0;
  if (seconds < t_up) {
    s = seconds * (v0 + 0.5 * (cruise - v0) * seconds / t_up);
  } else if (seconds < t_up + t_cruise) {
    s = 0.5 * (v0 + cruise) * t_up + cruise * (seconds - t_up);
  } else {
    const double rest = duration() - seconds;
    s = length - rest * (v1 + 0.5 * (cruise - v1) * rest / t_down);
  }
  return std::clamp(s / length, 0.0, 1.0);
}

Timed Timed::slower(double factor) const {
  Timed timed = *this;
  for (double* seconds : {&timed.start, &timed.t_up, &timed.t_cruise, &timed.t_down, &timed.element.pause})
    *seconds *= factor;
  for (double* speed : {&timed.v0, &timed.cruise, &timed.v1}) *speed /= factor;
  return timed;
}

double TimeCourse::seconds_at(double share) const {
  if (!(share > 0.0)) return 0.0;
  if (share >= 1.0) return duration();
  // Time for a way from a speed on, at a constant acceleration.
  const auto ramp = [](double way, double from, double to, double seconds) {
    const double acceleration = (to - from) / seconds;
    return 2.0 * way / (from + std::sqrt(std::max(0.0, from * from + 2.0 * acceleration * way)));
  };
  const double s = share * length, up = 0.5 * (v0 + cruise) * t_up, down = 0.5 * (cruise + v1) * t_down;
  if (s < up) return ramp(s, v0, cruise, t_up);
  if (length - s < down) return duration() - ramp(length - s, v1, cruise, t_down);
  return cruise > 0.0 ? t_up + (s - up) / cruise : 0.0;
}

Planner::Planner(PlannerOptions options, std::function<void(const Timed&)> take)
    : options_(std::move(options)),
      look_ahead_(options_.look_ahead),
      take_(std::move(take)) {}

void Planner::push(Element element) {
  Planned planned;
  planned.element = std::move(element);
  const Element& e = planned.element;
  if (e.pause > 0.0) {
    planned.limit = 0.0;
  } else {
    const Positions fastest = e.fastest() / e.length;
    double speed = e.rapid || !(e.speed > 0.0) ? std::numeric_limits<double>::infinity() : e.speed,
           acceleration = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < fastest.size(); ++i) {
      if (!(fastest[i] > 0.0)) continue;
      speed = std::min(speed, options_.axes[i].speed / fastest[i]);
      acceleration = std::min(acceleration, options_.axes[i].acceleration / fastest[i]);
    }
    if (options_.block_cycle > 0.0) speed = std::min(speed, e.length / options_.block_cycle);
    if (e.angle > 0.0) {
      // Part of the acceleration bends the path, the rest changes the speed along it.
      speed = std::min(speed, std::sqrt(0.87 * acceleration * std::max(e.length / e.angle, 1e-12)));
      acceleration *= 0.5;
    }
    // Only axes without a letter would leave it unlimited; they do not move.
    planned.limit = std::isfinite(speed) ? speed : 1.0;
    planned.acceleration = std::isfinite(acceleration) ? acceleration : 1.0;
  }
  planned.full = planned.acceleration;
  planned.corner = held_.empty() ? speed_ : corner_speed(held_.back(), planned);
  held_.push_back(std::move(planned));
  if (held_.size() >= 2 * look_ahead_ + 2) release(look_ahead_ + 1);
}

/// From rest to rest with half of the acceleration.
void Planner::overlap(Planned& planned) {
  planned.acceleration = 0.5 * planned.full;
  if (++planned.overlaps == 2)
    planned.limit = std::min(planned.limit, std::sqrt(planned.acceleration * planned.element.length));
}

double Planner::corner_speed(Planned& before, Planned& after) const {
  const Element &a = before.element, &b = after.element;
  if (a.pause > 0.0 || b.pause > 0.0 || a.exact_stop) return 0.0;
  Positions out = a.derivative(1.0), in = b.derivative(0.0);
  // A radian counts as a metre.
  const double n_out = out.norm(), n_in = in.norm();
  if (!(n_out > 0.0) || !(n_in > 0.0)) return 0.0;
  const double most = std::min(before.limit, after.limit);
  const double cosine = std::clamp(out.dot(in) / (n_out * n_in), -1.0, 1.0);
  if (cosine > 1.0 - 1e-9) return most;
  if (a.path_mode == 2 && a.last) return 0.0;
  const double half = std::sqrt(0.5 * (1.0 + cosine)), sine = std::sqrt(0.5 * (1.0 - cosine));  // of half the turn
  const double tolerance = a.path_mode == 3 && a.tolerance > 0.0 ? a.tolerance : options_.blend_tolerance;
  const double acceleration = std::min(before.full, after.full);
  if (options_.overlaps && sine >= sharp * half) {
    overlap(before);
    overlap(after);
    const double way = std::min({a.length, b.length, 4.0 * tolerance / sine});
    return std::min({before.limit, after.limit, std::sqrt(0.5 * acceleration * way)});
  }
  const double radius = std::min(tolerance * half / std::max(1.0 - half, 1e-12),
                                 0.5 * std::min(a.length, b.length) * half / std::max(sine, 1e-12));
  return std::min(most, std::sqrt(acceleration * radius));
}

void Planner::release(std::size_t count) {
  // Backwards: the speed from which all that follows can be braked; the last one may have to stop.
  double after = 0.0;
  for (std::size_t k = held_.size(); k-- > 0;) {
    Planned& p = held_[k];
    const double most =
        p.element.pause > 0.0 ? 0.0 : std::sqrt(after * after + 2.0 * p.acceleration * p.element.length);
    p.v0 = std::min({p.corner, p.limit, most});
    after = p.v0;
  }
  for (std::size_t k = 0; k < count && !held_.empty(); ++k) {
    const double next = held_.size() > 1 ? held_[1].v0 : 0.0;
    Planned first = std::move(held_.front());
    held_.pop_front();
    first.v0 = std::min(first.v0, speed_);
    const double reach = first.element.pause > 0.0
                             ? 0.0
                             : std::sqrt(first.v0 * first.v0 + 2.0 * first.acceleration * first.element.length);
    const double v1 = std::min(next, reach);
    give(first, v1);
    speed_ = v1;
  }
  if (!held_.empty()) held_.front().corner = std::min(held_.front().corner, speed_);
}

void Planner::give(const Planned& planned, double v1) {
  Timed timed;
  timed.element = planned.element;
  timed.start = time_;
  if (planned.element.pause > 0.0) {
    timed.t_cruise = planned.element.pause;
  } else {
    const double length = timed.length = planned.element.length, a = planned.acceleration, v0 = planned.v0;
    const double peak = std::sqrt(std::max(0.0, a * length + 0.5 * (v0 * v0 + v1 * v1)));
    timed.v0 = v0;
    timed.v1 = v1;
    timed.cruise = std::max({std::min(peak, planned.limit), v0, v1});
    timed.t_up = (timed.cruise - v0) / a;
    timed.t_down = (timed.cruise - v1) / a;
    const double rest = length - 0.5 * (v0 + timed.cruise) * timed.t_up - 0.5 * (v1 + timed.cruise) * timed.t_down;
    timed.t_cruise = timed.cruise > 0.0 ? std::max(0.0, rest) / timed.cruise : 0.0;
  }
  time_ += timed.duration();
  take_(timed);
}

void Planner::finish() {
  release(held_.size());
  speed_ = 0.0;
}

}  // namespace thermotwin::nc
