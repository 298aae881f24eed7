// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// VTK XML unstructured grids.

#include <filesystem>

#include "mesh/body/tet_mesh.h"
#include "mesh/import/raw_mesh.h"

namespace thermotwin::mesh {

/// Writes tetrahedra and the triangles of all groups as .vtu (VTK XML, appended data, LZ4).
void write_vtu(const std::filesystem::path& path, const TetMesh& mesh);

/// VTK XML unstructured grid. @throws MeshError
RawMesh read_vtu(const std::filesystem::path& path);

}  // namespace thermotwin::mesh
