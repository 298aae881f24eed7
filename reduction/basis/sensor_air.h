// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The air beside each sensor, which it takes on where it hangs loose.

#include <Eigen/Core>

#include "reduction/model/reduced_model.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// For each sensor on a body: the film of that body whose nearest triangle is nearest to the sensor.
/// @param basis  (size x r)
SensorAir sensor_air(const solver::FullModel& full, const Eigen::MatrixXd& basis);

}  // namespace thermotwin::reduction
