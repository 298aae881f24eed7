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

/// One cycle has none to be compared with: its errors are against the nominal chain.
void compare_nothing(RTestRecord& record);

bool has_deviations(const core::Table& table);

/// Chain with the points of its rotary axes, radius of the table, uncertainty, reference, drift and the errors that are
/// stated. @throws InputError
void read_common(const core::Node& root, RTestRecord& record);

}  // namespace thermotwin::metrology
