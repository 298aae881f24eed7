// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What probes record of a virtual R-Test: raw signals of each point, and the calibration before it, with the noise of
// the probes and the repeatability of the linear axes.

#include <Eigen/Core>

#include <cstdint>
#include <vector>

#include "core/normal_draws.h"
#include "metrology/plan/test_plan.h"
#include "metrology/probe/raw_signals.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::metrology {

/// @param error  (points) tool - table, m @param setup  with record = 0 each point is one sample
RawSignals probe_signals(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                         const std::vector<solver::Vector6>& error, const ProbeSetup& setup, std::uint64_t seed);

}  // namespace thermotwin::metrology
