// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// When the axes are where: speeds along the path with limited speed and acceleration of each axis, two passes over the
// elements that the control looks ahead. An element takes the speed that all of these allow:
//   the feed; |dq_i/ds| v <= speed_i; |dq_i/ds| a <= acceleration_i; v^2 / r <= 0.87 a on an arc.
// At a corner the path is rounded by a circle that deviates by the tolerance d, so that
//   v^2 <= a r,  r = min(d c / (1 - c), l / (2 tan(half the angle))),  c = cos(half the angle between the directions),
// with l the shorter of both elements, whose halves the circle may take. No element is shorter than the control's
// block cycle. A control that overlaps sharp corners (LinuxCNC) does so from tan(half the angle) = 0.87 on: one element
// brakes while the next one accelerates, each with half of the acceleration, from rest to rest but for the overlap,
//   v^2 <= a/2 min(l, 4 d / sin(half the angle)).
// The program stops at a corner in exact stop mode, and in exact path mode unless the directions agree. Corners
// between the lines of one move, and those of angles (a radian counts as a metre), are rounded likewise. Speeds then
// follow from accelerating and braking as late as possible; jerk is not limited.

#include <deque>
#include <functional>
#include <vector>

#include "nc/control/control_profile.h"
#include "nc/motion/element.h"

namespace thermotwin::nc {

/// Time along an element: accelerates, cruises, brakes.
struct TimeCourse {
  double start = 0;                           ///< s from the start of the program
  double length = 0;                          ///< m or rad along the path; 0: a pause
  double v0 = 0, cruise = 0, v1 = 0;          ///< m/s or rad/s
  double t_up = 0, t_cruise = 0, t_down = 0;  ///< s
  double duration() const { return t_up + t_cruise + t_down; }
  double end() const { return start + duration(); }
  /// Share of the element that is done after a time from its start.
  double share_at(double seconds) const;
  /// s from its start until a share is done: the inverse.
  double seconds_at(double share) const;
};

struct Timed : TimeCourse {
  Element element;
  /// The same motion in a multiple of the time, from the same multiple of its start.
  Timed slower(double factor) const;
};

struct PlannerOptions {
  std::vector<AxisLimits> axes;   ///< (axes of the machine)
  double blend_tolerance = 2e-5;  ///< m, where the program states none
  double block_cycle = 0;         ///< s, shortest time of an element
  int look_ahead = 500;           ///< elements
  bool overlaps = false;          ///< at sharp corners
};

class Planner {
public:
  Planner(PlannerOptions options, std::function<void(const Timed&)> take);

  void push(Element element);
  void finish();  ///< plans the rest; the axes stand at the end
  double time() const { return time_; }

private:
  struct Planned {
    Element element;
    double limit = 0, acceleration = 0;  ///< along the path
    double corner = 0;                   ///< largest speed at its start
    double full = 0;                     ///< acceleration without an overlap
    int overlaps = 0;                    ///< ends at which it overlaps
    double v0 = 0;
  };
  double corner_speed(Planned& before, Planned& after) const;
  static void overlap(Planned& planned);
  /// Plans all that is held and gives out the first ones. @param count  of them
  void release(std::size_t count);
  void give(const Planned& planned, double v1);

  PlannerOptions options_;
  std::size_t look_ahead_;
  std::function<void(const Timed&)> take_;
  std::deque<Planned> held_;
  double time_ = 0, speed_ = 0;  ///< speed at the start of the first held element
};

}  // namespace thermotwin::nc
