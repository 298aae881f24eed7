// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Which boundary triangles of a mesh the rules of a surface pick.

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Boundary triangles that fulfil all conditions of the rule, rising. On a cylinder, corners count
/// as well as the centre, which lies inside it by the height of the chord.
/// @throws InputError if there is none: says for each condition how near the nearest one is
std::vector<int> select_faces(const TetMesh& mesh, const Rule& rule);

/// Boundary triangles of every surface of the machine, rising; exceptions taken out.
/// @param bodies  one mesh per Machine::bodies  @throws InputError for a surface without triangles
std::vector<std::vector<int>> resolve_surfaces(const Machine& machine, const std::vector<TetMesh>& bodies);

}  // namespace thermotwin::mesh
