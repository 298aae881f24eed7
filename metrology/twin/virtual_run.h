// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A thermal test on the full model of a machine. The load program of the plan, with its interruptions by the
// measurements, drives the model; each point is taken at its own time, so the drift during a cycle is in the points.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "metrology/plan/test_plan.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/elastic/tcp.h"
#include "solver/operation/load_program.h"

namespace thermotwin::metrology {

struct VirtualRun {
  solver::LoadResult load;              ///< sensors and inputs at the outputs of the run
  std::vector<solver::Vector6> error;   ///< (points) tool - table there and then, m and rad, machine frame
  std::vector<solver::Vector6> frozen;  ///< (points) the same, all of a cycle in its middle
  std::vector<solver::Vector6> table;   ///< (points) the table's share of frozen, as if the tool stood still
  std::vector<double> middle;           ///< (cycles) s
  std::vector<std::string> quantities;  ///< location errors of the machine ...
  Eigen::MatrixX2d surface_at;          ///< (nodes x 2) m, of the table's surface in its frame; none: not asked for
  Eigen::MatrixXd surface;  ///< (cycles x nodes) m, their rise in the middle of the cycle against the foundation
  Eigen::MatrixXd
      functionals;  ///< ... (cycles x quantities) in the middle of the cycle, um and um/m, mean over its positions
};

struct VirtualRunOptions {
  std::vector<std::string> quantities;  ///< location errors whose functionals are computed
  bool surface = false;                 ///< heights of the table's surface are computed
  double rows_every = 60;               ///< s, between outputs of sensors and inputs
  solver::TimeOptions time{solver::TimeScheme::adaptive, 0.1, 1.0, 21600};
  double refine = 0.63;   ///< factor of its tolerance
  void validate() const;  ///< @throws InputError
};

/// @param points  in order of time, in [0, duration of the load)
VirtualRun run_virtually(const solver::FullModel& full, const solver::LoadProgram& load,
                         const std::vector<PlannedPoint>& points, const VirtualRunOptions& options);

}  // namespace thermotwin::metrology
