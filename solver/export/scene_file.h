// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// scene.bin: the skin of a machine and modes of its fields there, without loads, so that runs of the reduced model,
// which has no mesh, can be looked at. Single precision.

#include <filesystem>
#include <optional>

#include "solver/export/machine_scene.h"

namespace thermotwin::solver {

/// Whole or not at all. @param made_from  the reduced model that turn belongs to, e.g. a hash of its matrices
void write_scene(const std::filesystem::path& path, const MachineScene& scene, const std::string& made_from);

/// @return nothing where there is no such file, or one of another machine, model or version
std::optional<MachineScene> read_scene(const std::filesystem::path& path, const mesh::Machine& machine,
                                       const std::string& made_from);

}  // namespace thermotwin::solver
