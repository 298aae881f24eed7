// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the ambients, films and sources of machine.toml, with volumes and coolants (coolant_file.h).

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// @throws InputError naming file, line and key
void read_physics(const core::Node& root, Draft& draft);

}  // namespace thermotwin::mesh::reader
