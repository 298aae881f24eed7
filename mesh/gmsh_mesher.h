// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Volume meshes by Gmsh, whose state is global: every call takes one lock for the whole program.
// Nothing of it reaches stdout. The same input gives the same mesh, bit by bit.

#include "mesh/import.h"
#include "mesh/raw_mesh.h"
#include "mesh/surface_parts.h"

namespace thermotwin::mesh {

/// STEP (its own unit counts) or BREP (unit_m counts); several solids get one conformal mesh.
/// Groups: names of solids and, of a single solid, of faces. @throws MeshError
TetMesh mesh_cad(const std::filesystem::path& path, const ImportOptions& options);

/// Mesh of a closed surface, possibly with cavities: it is cut along edges sharper than 40 deg,
/// the patches are remeshed to the element size, and the volume is filled. No groups.
/// @param surface  one piece, in m, checked  @throws MeshError
TetMesh mesh_closed_surface(const Surface& surface, const ImportOptions& options);

/// A Gmsh mesh file (.msh 4.1, 2.2); sets are its physical groups. @throws MeshError
RawMesh read_msh(const std::filesystem::path& path);

}  // namespace thermotwin::mesh
