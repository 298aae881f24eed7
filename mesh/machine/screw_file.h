// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Screws of machine.toml, and which of an axis's measuring systems is active.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

void read_screws(const core::Node& root, Draft& draft);

}  // namespace thermotwin::mesh::reader
