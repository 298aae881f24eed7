// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The plan of a thermal test after ISO 230-3 or of an R-Test (Gebhardt 2014, 4.1.2 and 5.2.1): a reference measurement,
// intervals of load each followed by a measurement, then intervals of standstill each followed by one. The time between
// the end of a measurement and the start of the next is the interval. The plan has the blocks of the NC program and the
// points that are measured, at poses where the tool point meets the sphere on the table.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "metrology/plan/plan_options.h"
#include "metrology/plan/timeline.h"

namespace thermotwin::metrology {

struct PlannedPoint {
  double time = 0;  ///< s, middle of its record
  int cycle = 1;
  int place = 1;  ///< number of its pose within the cycle
  mesh::Pose pose;
  Eigen::Vector3d sphere = Eigen::Vector3d::Zero();  ///< m, nominal centre in the machine frame
};

struct TestPlan {
  PlanOptions options;
  std::string tested;  ///< id of the axis; empty: none
  Timeline timeline;
  std::vector<PlannedPoint> points;
  bool is_rtest() const;  ///< location errors rather than displacements
};

/// @param machine  must outlive the plan; its tool point is that of the test
/// @throws InputError: an axis that the test cannot have, a travel or speed beyond a limit
TestPlan make_plan(const mesh::Machine& machine, const PlanOptions& options);

}  // namespace thermotwin::metrology
