// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine from machine.toml.

#include <filesystem>
#include <string>

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// @throws InputError naming file, line, key; every reference between ids is checked
Machine read_machine(const std::filesystem::path& path);

/// From text (a model file keeps it); paths in it are relative to folder and need not exist.
Machine parse_machine(const std::string& text, const std::filesystem::path& path);

}  // namespace thermotwin::mesh
