// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Selects the boundary triangles of a mesh by the rules of a surface.

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// @return the boundary triangles that fulfil all conditions of the rule, rising. On a cylinder the corners are tested
///   as well, because the centre lies inside it by the height of the chord
/// @throws InputError if there is none, with the distance of the nearest triangle for each condition
std::vector<int> select_faces(const TetMesh& mesh, const Rule& rule);

/// @return the boundary triangles of every surface of the machine, rising, without its exceptions
/// @param bodies  one mesh per Machine::bodies  @throws InputError for a surface without triangles
std::vector<std::vector<int>> resolve_surfaces(const Machine& machine, const std::vector<TetMesh>& bodies);

}  // namespace thermotwin::mesh
