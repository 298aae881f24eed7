// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the screws of machine.toml and decides which measuring system of an axis is active.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// @throws InputError naming file, line and key
void read_screws(const core::Node& root, Draft& draft);

}  // namespace thermotwin::mesh::reader
