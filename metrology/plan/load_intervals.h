// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the axes and the spindle do between two measurements: turn, go to and fro, stand. A motion ends where it began
// and fills the interval as far as whole turns and strokes do; the rest is a dwell.

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "metrology/plan/timeline.h"

namespace thermotwin::metrology {

/// A load: an axis, or the spindle (axis -1).
struct LoadMotion {
  int axis = -1;
  double speed = 0;          ///< rad/s or m/s; of the spindle rpm; 0: it stands
  double low = 0, high = 0;  ///< m or rad; where they are equal, a limited axis stands there
};

/// Adds an interval: a stage for the way to positions that are held, where there is one, then a stage in which they are
/// held. Moving axes go one after the other, each for an equal share of the time.
void add_load_interval(const mesh::Machine& machine, Timeline& timeline, const std::vector<LoadMotion>& loads,
                       double seconds, const std::string& name);

/// Loads of a random cycle (Gebhardt 2014, 5.2.1): after each interval it is drawn whether they change; a new speed is
/// uniform between two limits. A limited axis goes to and fro between two random positions, or stands at one, with
/// equal probability.
class RandomLoads {
public:
  struct Limits {
    LoadMotion widest;               ///< travel of the load
    double lowest = 0, highest = 0;  ///< speed
  };
  RandomLoads(std::vector<Limits> limits, double change_probability, bool standstills, std::uint64_t seed);
  /// The loads of the next interval.
  const std::vector<LoadMotion>& next();

private:
  double uniform();  ///< in [0, 1)

  std::vector<Limits> limits_;
  double change_probability_;
  bool standstills_;
  std::mt19937_64 engine_;
  std::vector<LoadMotion> loads_;
};

}  // namespace thermotwin::metrology
