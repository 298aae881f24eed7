// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Meshes kept on disk: meshing a machine takes a minute, reading it back a moment. A file that is
// damaged, or of another version or byte order, counts as absent.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "mesh/import/import.h"

namespace thermotwin::mesh {

/// Name of the body's file: it changes with the CAD file's content, the options and the mesher.
/// @return empty if the file's content does not say everything (.gltf refers to other files)
std::string cache_name(const std::filesystem::path& cad, const ImportOptions& options);

/// The mesh as bytes of this build and machine, and back. @return nothing for bytes that are damaged
std::string pack_mesh(const TetMesh& mesh);
std::optional<TetMesh> unpack_mesh(std::string_view bytes);

std::optional<TetMesh> read_cached(const std::filesystem::path& file);

/// A failure is a warning: the mesh exists without its copy.
void write_cached(const std::filesystem::path& file, const TetMesh& mesh);

}  // namespace thermotwin::mesh
