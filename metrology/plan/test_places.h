// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The poses at which a test measures.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "metrology/plan/plan_options.h"

namespace thermotwin::metrology {

struct TestPlaces {
  int axis = -1;                         ///< tested; -1: none
  bool on_sphere = false;                ///< the tool point meets a sphere on the table; else it stands in the air
  std::vector<Eigen::Vector3d> spheres;  ///< (poses) m, table's home frame; in the air none
  std::vector<mesh::Pose> poses;         ///< of a cycle, in order; of a continuous test both ends
};

/// Discrete tests end at their first pose, so that the drift shows.
/// @param rest  where the other axes stand @param place  of messages  @throws InputError
TestPlaces test_places(const mesh::Machine& machine, const PlanOptions& options, const mesh::Pose& rest,
                       const std::string& place);

/// @throws InputError for an axis that the machine does not have
int axis_named(const mesh::Machine& machine, const std::string& id, const std::string& place);

}  // namespace thermotwin::metrology
