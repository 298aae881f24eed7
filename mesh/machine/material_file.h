// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads [[material]] of machine.toml.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// @throws InputError naming file, line and key
Material read_material(const core::Node& node, Draft& draft);

}  // namespace thermotwin::mesh::reader
