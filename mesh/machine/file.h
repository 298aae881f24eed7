// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads a machine from machine.toml.

#include <filesystem>
#include <string>

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Reads and checks machine.toml, with every reference between ids. @throws InputError naming file, line and key
Machine read_machine(const std::filesystem::path& path);

/// Reads a machine from the text that a model file keeps. @param path  its file; the CAD files beside it need not exist
Machine parse_machine(const std::string& text, const std::filesystem::path& path);

}  // namespace thermotwin::mesh
