// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Volumes, doors and coolant circuits of machine.toml.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

void read_volumes(const core::Node& root, Draft& draft);

void read_coolants(const core::Node& root, Draft& draft);

}  // namespace thermotwin::mesh::reader
