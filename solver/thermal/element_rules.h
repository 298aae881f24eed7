// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Quadrature of capacity and films. `consistent` is exact. `reduced` is that of CalculiX: one point for linear
// tetrahedra (C3D4); four points in the volume and three on a triangle for quadratic ones (C3D10). It serves only
// comparisons with CalculiX node by node, because the capacity matrix of an element is then singular.

#include "solver/thermal/assembly.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

enum class ElementRules { consistent, reduced };

/// assemble_thermal(mesh) of assembly.h uses `consistent`.
ThermalSystem assemble_thermal(const mesh::MachineMesh& mesh, ElementRules rules);

}  // namespace thermotwin::solver
