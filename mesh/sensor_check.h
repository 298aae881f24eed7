// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A sensor reads the nearest point of its body. That is what is wanted beside a faceted cylinder,
// and a slip of a digit or of the body where the point lies far off.

#include <vector>

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// @throws InputError for a sensor that is further outside its body than one of its elements
void check_sensors(const Machine& machine, const std::vector<TetMesh>& bodies);

}  // namespace thermotwin::mesh
