// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Faults of meshed bodies that no equation notices: parts of a body that do not touch each other, two
// bodies in the same place, elements of very poor quality.

#include <string>
#include <vector>

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Quality (see mesh::quality) below which a body is warned of: one such element spoils the condition of
/// the equations and the gradients in it.
inline constexpr double poor_quality = 0.02;

/// Piece of each element: 0 for that of element 0, and so on. Elements that share a node are connected.
struct Pieces {
  std::vector<int> of_element;
  int count = 0;
};
Pieces connected_pieces(const TetMesh& mesh);

/// @throws MeshError unless the body has spec.pieces pieces: which, where, how far from the others
void check_pieces(const BodySpec& spec, const TetMesh& mesh, const std::string& place);

/// All axes at home. Counted are elements of one body whose centre lies in the other.
/// @throws MeshError where they make up more than 0.5 % of the smaller body: which two, where, how much
void check_overlaps(const Machine& machine, const std::vector<TetMesh>& bodies);

/// Warns where the worst element is below poor_quality.
void warn_of_poor_quality(const BodySpec& spec, const TetMesh& mesh);

}  // namespace thermotwin::mesh
