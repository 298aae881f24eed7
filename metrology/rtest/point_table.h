// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the records of an R-Test and of a volumetric grid share: points.csv in cycles, and the tables [[axis]].

#include <vector>

#include "core/config.h"
#include "core/table.h"
#include "mesh/machine/kinematic_chain.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

/// @param raw  the deviations are not in the table
/// @throws InputError: an unknown column, a missing value, time or cycles that run back, no points
std::vector<RTestCycle> read_cycles(const core::Table& table, const mesh::KinematicChain& chain, bool raw);

bool has_deviations(const core::Table& table);

/// Points on the rotary axes, and axes that move the workpiece with their letter. @throws InputError
void read_axes(const core::Node& root, mesh::KinematicChain& chain);

}  // namespace thermotwin::metrology
