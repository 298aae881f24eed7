// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Fills the data of the online core's observer (observer_data.h, deviation.h) from a reduced model.

#include "compensation/control/control_data.h"
#include "compensation/online/compensator.h"
#include "compensation/online/output_map.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {

/// @param operating  of the model  @param map  of the model  @param options  steps and start
void fill_observer(const reduction::ReducedModel& model, const solver::OperatingModel& operating, const OutputMap& map,
                   const CompensatorOptions& options, ControlData& data);

}  // namespace thermotwin::compensation
