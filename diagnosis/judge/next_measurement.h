// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What to measure next where causes share the probability: of all load programs and all sensors and poses
// of the machine the ones by which the sharing causes differ most, in units of what can be read there.

#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"
#include "solver/operation/load_program.h"

namespace thermotwin::diagnosis {

/// @param programs  that could be run, beside the load of the measurement itself, repeated with more channels
NextMeasurement next_measurement(const Problem& problem, const reduction::ReducedModel& model,
                                 const std::vector<solver::LoadProgram>& programs, const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
