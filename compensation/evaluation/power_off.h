// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Study of the return from a power-off: a machine works, is switched off together with the compensator for hours, and
// works again. The compensator then starts from its sensor readings only.

#include <cstdint>
#include <string>
#include <vector>

#include "compensation/evaluation/validation.h"

namespace thermotwin::compensation {

/// A day's work at random, a power-off of half an hour to ten hours, and work again, as the text of a
/// load program: every axis and the spindle may move, the hall is 2 K cooler to 12 K warmer than the reference.
std::string random_power_off(const mesh::Machine& machine, std::uint64_t seed);

/// The same, ready to run.
MeasuredLoad power_off_load(const mesh::Machine& machine, std::uint64_t seed);

/// RMS of the TCP error over the check points at three times after the return: 5 min, 30 min, 2 h.
struct PowerOffRow {
  int draw = 0;
  double hall_C = 0, worked_h = 0, off_h = 0;
  double before_um[3] = {0, 0, 0};   ///< without compensation
  double left_um[3] = {0, 0, 0};     ///< with compensation
  double unmoved_um[3] = {0, 0, 0};  ///< the part of both in directions that no linear axis moves
};

struct PowerOffStudy {
  std::vector<PowerOffRow> rows;
  Eigen::Index measured_nodes = 0;
  std::string unmoved_directions;  ///< as of Validation
  /// What of the residuals no linear axis moves; empty: nothing.
  std::string unmoved_sentence() const;
  /// @return the remaining share of the error of each machine, %  @param moment  index 0 to 2 of the time
  std::vector<double> left_percent(int moment) const;
  Rows table() const;  ///< one row for each machine; median and 90th percentile last
  std::string brief() const;
  Rows summary() const;  ///< medians and 90th percentiles
  PowerOffStudy first(int draws) const;
};

PowerOffStudy study_power_off(const solver::Case& machine_case, const reduction::ReducedModel& model,
                              const ValidationOptions& options);

}  // namespace thermotwin::compensation
