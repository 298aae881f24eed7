// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Names and units of the states of the error model (error_model.h) beside the machine's quantities.

#include <Eigen/Core>

#include "compensation/online/error_model.h"
#include "mesh/machine/machine.h"

namespace thermotwin::compensation {

/// @param mode  0: uniform temperature; k: pattern k of earlier work
ErrorModel::State start_state(Eigen::Index mode);
ErrorModel::State sensor_offset_state(const mesh::Machine& machine, Eigen::Index sensor);
/// @param output  0 to 2: motion of the tool side along x y z; 3 to 5: of the table side; 6 to 8: remainder
ErrorModel::State output_state(Eigen::Index output);
/// @param drive  its name ("spindle", "axis X")
ErrorModel::State unrecorded_state(const std::string& drive);

}  // namespace thermotwin::compensation
