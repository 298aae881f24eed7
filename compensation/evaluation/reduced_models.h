// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced model of the machine beside the models that are fitted.

#include <string>

#include "compensation/evaluation/scoring.h"
#include "compensation/measurement/measurement.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

void score_reduced_model(const Measurement& measurement, const reduction::ReducedModel& model, const std::string& name,
                         bool with_sensors, Scorer& scorer);

/// Predicted time series of a displacement channel's quantity by the compensator (um or um/m).
/// @param errors  TCP error at the channel's pose per time
Eigen::VectorXd quantity_series(const std::vector<solver::TcpError>& errors, const MeasuredChannel& channel);

}  // namespace thermotwin::compensation
