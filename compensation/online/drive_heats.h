// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Heat of the drives: what the spindle and each axis put into the machine at half of their fastest speed, beyond
// that of the machine standing. A measure of a day's work, and of a heat that nobody tells.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "reduction/model/reduced_model.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {

struct DriveHeat {
  std::string name;       ///< "spindle", "axis X"
  int channel = -1;       ///< of its speed or feed; -1: the machine has none
  double half_speed = 0;  ///< in the channel's unit
  Eigen::VectorXd heat;   ///< (order) W on the basis
};

/// Heat of all sources, W on the basis. @param row  (channels)
Eigen::VectorXd source_heat(const reduction::ReducedSystem& system, const solver::OperatingModel& operating,
                            const Eigen::VectorXd& row);

/// What half speed adds to the drive standing, other inputs as in the row: none while the machine is off or the drive's
/// power is measured. @param row  (channels)  @return (order) W on the basis
Eigen::VectorXd heat_at_half_speed(const reduction::ReducedSystem& system, const solver::OperatingModel& operating,
                                   const DriveHeat& drive, Eigen::VectorXd row);

/// The spindle, then the axes. @param rest  (channels) of the machine standing
std::vector<DriveHeat> drive_heats(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
                                   const Eigen::VectorXd& rest);

}  // namespace thermotwin::compensation
