// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs load programs of one time grid side by side, each with an operating model of its own: machines that differ in
// coefficients only, such as powers, films and contacts, share the stepper's matrices and factors.

#include <functional>
#include <vector>

#include "solver/campaign/simulation.h"

namespace thermotwin::solver {

/// @param models  one per program, with the stepper's layout
/// @param on_output  called in order of time for each program at each output time; after a resumed start only for
///   outputs that the checkpoint does not hold
/// @throws InputError if the time grids differ; Interrupted (a last checkpoint is then written)
RunSummary simulate_block(ThermalStepper& stepper, const std::vector<const OperatingModel*>& models,
                          const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
                          const std::function<void(const OutputState&)>& on_output);

}  // namespace thermotwin::solver
