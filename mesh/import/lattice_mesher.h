// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A body from a surface that is too faulty to be meshed: the key mesher = "lattice" of a body.

#include "mesh/body/tet_mesh.h"
#include "mesh/import/import.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Fills what the surface encloses (shells that overlap are one body, holes are closed) and says how much of the
/// volume it holds. Where that differs by more than a tenth, a finer lattice follows, within max_elements.
/// @param surface  in m; its normals mostly point outwards
/// @throws MeshError for an open surface, and where walls are too thin for the element size
TetMesh lattice_mesh(const Surface& surface, const ImportOptions& options);

}  // namespace thermotwin::mesh
