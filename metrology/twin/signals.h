// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What probes record of a virtual R-Test: raw signals of each point, and the calibration before it, with the noise of
// the probes and the repeatability of the linear axes.

#include <Eigen/Core>

#include <cstdint>
#include <random>
#include <vector>

#include "metrology/plan/test_plan.h"
#include "metrology/probe/raw_signals.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::metrology {

/// Normal numbers that a seed makes the same everywhere.
class NormalDraws {
public:
  explicit NormalDraws(std::uint64_t seed) : engine_(seed) {}
  double operator()();
  Eigen::Vector3d vector() { return {(*this)(), (*this)(), (*this)()}; }

private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// @param error  (points) tool - table, m @param setup  with record = 0 each point is one sample
RawSignals probe_signals(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                         const std::vector<solver::Vector6>& error, const ProbeSetup& setup, std::uint64_t seed);

}  // namespace thermotwin::metrology
