// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// From the meshed machine to the matrices of heat.

#include "mesh/machine_mesh.h"
#include "solver/thermal/element_rules.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// @throws InputError (a joint without any contact over the travel, a surface of zero area)
ThermalSystem assemble_thermal(
    const mesh::MachineMesh& mesh);  // local terms refer to the mesh, which must outlive them

}  // namespace thermotwin::solver
