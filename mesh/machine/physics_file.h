// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Ambients, films and sources of machine.toml, with volumes and coolants (coolant_file.h).

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

void read_physics(const core::Node& root, Draft& draft);

}  // namespace thermotwin::mesh::reader
