// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Checks meshed bodies for faults that no equation detects: unconnected parts of a body, overlapping bodies, and
// elements of very poor quality.

#include <string>
#include <vector>

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Quality (see mesh::quality) below which a warning is given. One such element impairs the condition of the equations
/// and the gradients in it.
inline constexpr double poor_quality = 0.02;

/// The piece of each element; element 0 is in piece 0. Elements that share a node are connected.
struct Pieces {
  std::vector<int> of_element;
  int count = 0;
};
Pieces connected_pieces(const TetMesh& mesh);

/// @throws MeshError unless the body has spec.pieces pieces, with the place of a piece and its distance to the others
void check_pieces(const BodySpec& spec, const TetMesh& mesh, const std::string& place);

/// Counts the elements of one body whose centre lies in another one, with all axes at home.
/// @throws MeshError if they fill more than 0.5 % of the smaller body, with both bodies, the place and the volume
void check_overlaps(const Machine& machine, const std::vector<TetMesh>& bodies);

/// Warns if the worst element is below poor_quality.
void warn_of_poor_quality(const BodySpec& spec, const TetMesh& mesh);

}  // namespace thermotwin::mesh
