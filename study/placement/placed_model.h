// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A case and its reduced model with other sensors, to confirm a choice on machines measured virtually.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine_mesh.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "study/placement/candidates.h"

namespace thermotwin::study {

/// @return sensors at the places, "S1" ..., then those of the machine that a chiller follows, whose ids are not given
/// again
std::vector<mesh::SensorSpec> placed_sensors(const mesh::Machine& machine, const std::vector<Place>& places);

/// The case with these sensors; its machine has a hash of its own, since its text has others.
solver::Case placed_case(const solver::Case& machine_case, const std::vector<mesh::SensorSpec>& sensors);

/// The model with these sensors. @param rows  (places x order) temperatures of the places, in the order of the sensors
reduction::ReducedModel placed_model(const reduction::ReducedModel& model, const mesh::Machine& placed,
                                     const Eigen::MatrixXd& rows);

}  // namespace thermotwin::study
