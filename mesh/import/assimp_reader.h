// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Surface files by assimp.

#include <filesystem>
#include <string>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Loads the module now, so that child processes have it.
void load_assimp();

/// The triangles of a file by assimp, node transforms applied, in units of the file, not welded.
/// @throws InputError if the file cannot be read; MeshError if it has no triangles
Surface read_triangles(const std::filesystem::path& path, const std::string& body);

}  // namespace thermotwin::mesh
