// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Heat of the drives: the heat that the spindle and each axis add at half of their largest speed to that of the
// standing machine. It is the scale of a day's work, and of the heat of a drive whose speed is not recorded.

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

/// @return the heat of all sources, (order) W on the basis  @param row  (channels)
Eigen::VectorXd source_heat(const reduction::ReducedSystem& system, const solver::OperatingModel& operating,
                            const Eigen::VectorXd& row);

/// @return the heat that half speed adds to the standing drive, other inputs as in the row, (order) W on the basis; 0
///   while the machine is off or the drive's power is measured  @param row  (channels)
Eigen::VectorXd heat_at_half_speed(const reduction::ReducedSystem& system, const solver::OperatingModel& operating,
                                   const DriveHeat& drive, Eigen::VectorXd row);

/// @return the heats of the spindle, then of the axes  @param rest  (channels) of the standing machine
std::vector<DriveHeat> drive_heats(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
                                   const Eigen::VectorXd& rest);

}  // namespace thermotwin::compensation
