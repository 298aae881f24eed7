// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How elements integrate capacity and films: exactly, or as CalculiX does, with one point for linear
// tetrahedra (C3D4) and for quadratic ones (C3D10) with four in the volume and three on a triangle.
// The second is for comparisons with it, node by node, and for nothing else: such a capacity does not
// see all that varies inside an element.

#include "solver/thermal/assembly.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

enum class ElementRules { consistent, reduced };

/// As assemble_thermal(mesh), which is consistent.
ThermalSystem assemble_thermal(const mesh::MachineMesh& mesh, ElementRules rules);

}  // namespace thermotwin::solver
