// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the volumes, doors and coolant circuits of machine.toml.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// Reads [[door]] and [[volume]]. @throws InputError
void read_volumes(const core::Node& root, Draft& draft);

/// Reads [[coolant]] with its segments. @throws InputError
void read_coolants(const core::Node& root, Draft& draft);

}  // namespace thermotwin::mesh::reader
