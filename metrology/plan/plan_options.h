// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Options of `measure plan`: a test after ISO 230-3 or an R-Test, its load, rest times, points and probes.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::metrology {

enum class TestKind {
  rtest,
  rtest_continuous,
  rtest_grid,
  etve,
  spindle,
  linear_axis,
  rotary_axis,
  random_cycle,
  volumetric_grid
};

const std::vector<std::string>& test_kinds();  ///< in the order of TestKind
/// @throws InputError for an unknown word
TestKind test_kind(const std::string& word);

struct PlanOptions {
  TestKind kind = TestKind::rtest;
  std::string axis;                ///< tested axis; empty: that of the table, for linear_axis the first linear one
  std::vector<std::string> loads;  ///< axes under load, or "spindle"; empty: the tested axis, of a grid none
  double speed = 0;  ///< load: rpm of the spindle and of endless axes, mm/min or deg/min; 0: half of the largest
  std::vector<double> range;  ///< mm or deg: pendular motion of the load; empty: four fifths of the travel
  double warm_up_h = 4, cool_down_h = 4, interval_min = 5;
  std::string pose;  ///< positions of the axes that the test does not move, "B=0"; empty: home
  double radius_mm = 190, height_mm = 150, clearance_mm = 30;
  std::vector<double> azimuths_deg{0.0};  ///< of the spheres on the table; a continuous test has one
  std::vector<double> angles_deg;         ///< of the tested axis, in a continuous test both ends; empty: by the travel
  std::vector<double> tilts_deg;  ///< rtest_grid: angles of the swivel axis; empty: 0, 30, 60, 90 within its travel
  double feed_deg_min = 600, feed_mm_min = 2000;  ///< of a continuous test; of approaches to a point
  double rate_Hz = 100, record_s = 3, cut_s = 1;  ///< of a point: samples, record, time left out at both ends
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
