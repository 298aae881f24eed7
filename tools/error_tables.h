// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Errors of a reduced model as cells, for the terminal and for pages.

#include <string>
#include <vector>

#include "tools/chain.h"

namespace thermotwin::tools {

/// Reduced against full on the held-out loads, at the stored poses.
std::vector<std::vector<std::string>> heldout_rows(const ReducedCase& made);
/// The same at poses between the stored ones; only a header where none were judged.
std::vector<std::vector<std::string>> off_grid_rows(const ReducedCase& made);
/// The sensor that is furthest off in each held-out load; only a header where the machine has none.
std::vector<std::vector<std::string>> sensor_rows(const ReducedCase& made);
/// What the mesh may be off by: percent of the motion in all directions, and of the change of each sensor.
std::vector<std::vector<std::string>> mesh_error_rows(const reduction::MeshError& error);

}  // namespace thermotwin::tools
