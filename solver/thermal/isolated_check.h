// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Parts of a machine that no film, joint, coolant or volume connects to anything that carries heat away: what is let
// in there stays, and their temperature rises without end.

#include <string>
#include <vector>

#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// One sentence a part: its body, how many nodes, where, and that nothing takes its heat.
std::vector<std::string> isolated_parts(const mesh::MachineMesh& mesh, const ThermalSystem& thermal);

}  // namespace thermotwin::solver
