// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What is asked of a plan.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::metrology {

enum class TestKind { rtest, rtest_continuous, rtest_grid, etve, spindle, linear_axis, rotary_axis, random_cycle };

const std::vector<std::string>& test_kinds();  ///< in the order of TestKind
/// @throws InputError for an unknown word
TestKind test_kind(const std::string& word);

struct PlanOptions {
  TestKind kind = TestKind::rtest;
  std::string axis;                ///< that is tested; empty: the table's, of linear_axis the first linear one
  std::vector<std::string> loads;  ///< axes under load, or "spindle"; empty: the tested axis
  double speed = 0;  ///< of the load: rpm of spindle and endless axes, mm/min or deg/min; 0: half of the largest
  std::vector<double> range;  ///< mm or deg: pendular motion of the load; empty: four fifths of the travel
  double warm_up_h = 4, cool_down_h = 4, interval_min = 5;
  std::string pose;  ///< where the axes stand that the test does not move, "B=0"; empty: home
  double radius_mm = 190, height_mm = 150, clearance_mm = 30;
  std::vector<double> azimuths_deg{0.0};  ///< a sphere at each; of a continuous test one
  std::vector<double> angles_deg;         ///< of the tested axis; of a continuous test both ends; empty: by the travel
  std::vector<double> tilts_deg;  ///< of a grid: of the axis below the table's; empty: 0, 30, 60, 90 in its travel
  double feed_deg_min = 600, feed_mm_min = 2000;  ///< of a continuous test; of approaches
  double rate_Hz = 100, record_s = 3, cut_s = 1;  ///< of a point: recorded, and left out at both ends
  std::vector<double> speeds;                     ///< of a random cycle: lowest and highest; empty: 0 and half
  double change_percent = 50;                     ///< of a random cycle: probability of another speed after an interval
  bool standstills = false;                       ///< of a random cycle: each load is followed by a standstill
  std::uint64_t seed = 1;
  std::optional<std::pair<double, double>> air_C;  ///< at both ends and in the middle of the test, linear between
  void validate() const;                           ///< @throws InputError
};

/// Range of the load's pendular motion of this axis, m or rad.
std::pair<double, double> load_range(const mesh::Machine& machine, int axis, const PlanOptions& options);

}  // namespace thermotwin::metrology
