// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How well a virtual R-Test finds the location errors of the machine that it measured.

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "metrology/plan/test_plan.h"
#include "metrology/probe/probe_setup.h"
#include "metrology/rtest/analysis.h"
#include "metrology/twin/virtual_run.h"

namespace thermotwin::metrology {

/// The record of these points without probes. @param deviations  (points) m
RTestRecord record_of(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                      const std::vector<solver::Vector6>& deviations, double std);

/// A pair of figures: of lengths in um and of angles in um/m. NaN: the test has none.
struct Figures {
  double um = std::numeric_limits<double>::quiet_NaN(), um_per_m = um;
};

struct RTestStudy {
  std::vector<std::string> errors;
  /// Largest difference to the functional, without noise and drift, both against the first cycle: of the estimate from
  /// the table's side alone, which is what the functional has, and of the test's, which has the tool's side too.
  Figures largest_difference, largest_with_tool;
  std::vector<double> difference;  ///< of the table's side alone, each error, um or um/m
  /// RMS over cycles and errors of what the drift during a cycle adds, and of what the correction leaves of it.
  Figures drift_adds, drift_leaves;
  /// Pooled over the cycles, without noise and drift, um: what the errors do not explain of a coordinate, and of the
  /// table's side alone. Against the noise it is what lifts the residuals of a record.
  double residual = std::numeric_limits<double>::quiet_NaN(), residual_of_table = residual;
  int draws = 0;
  double covered_percent = std::numeric_limits<double>::quiet_NaN();  ///< of the estimates without noise, by U (k = 2)
};

/// @param draws  of noise and calibration, for the coverage; 0: none
RTestStudy study(const mesh::Machine& machine, const std::vector<PlannedPoint>& points, const VirtualRun& run,
                 const ProbeSetup& setup, double std, int draws, std::uint64_t seed);

}  // namespace thermotwin::metrology
