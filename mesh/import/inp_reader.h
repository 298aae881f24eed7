// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Meshes of Abaqus and CalculiX.

#include <string>

#include "mesh/import/raw_mesh.h"

namespace thermotwin::mesh {

/// Abaqus or CalculiX text. @throws InputError with source and line
RawMesh parse_inp(const std::string& text, const std::string& source);

}  // namespace thermotwin::mesh
