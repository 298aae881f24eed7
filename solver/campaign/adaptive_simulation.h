// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs a load program with control of the time error.

#include <functional>

#include "solver/campaign/simulation.h"
#include "solver/thermal/adaptive.h"

namespace thermotwin::solver {

/// Runs one program with error control. Steps are the output interval times powers of two. They end at changes of the
/// program, at output times and at compressor switches, which are located on the dense output.
RunSummary simulate_adaptive(AdaptiveIntegrator& integrator, const OperatingModel& model, const LoadProgram& program,
                             const SimulationOptions& options,
                             const std::function<void(const OutputState&)>& on_output);

}  // namespace thermotwin::solver
