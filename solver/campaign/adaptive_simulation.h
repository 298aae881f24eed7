// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The main loop with error control.

#include <functional>

#include "solver/campaign/simulation.h"
#include "solver/thermal/adaptive.h"

namespace thermotwin::solver {

/// Runs one program with error control: steps of output interval times powers of two, ends at
/// corners, output times and compressor switches, these located on the dense output.
RunSummary simulate_adaptive(AdaptiveIntegrator& integrator, const OperatingModel& model, const LoadProgram& program,
                             const SimulationOptions& options,
                             const std::function<void(const OutputState&)>& on_output);

}  // namespace thermotwin::solver
