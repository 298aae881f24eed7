// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The module that holds assimp.

#include <filesystem>
#include <string>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// @return triangles as read_triangles() does, of a file that is there
using ReadTriangles = Surface (*)(const std::filesystem::path& path, const std::string& body);

}  // namespace thermotwin::mesh
