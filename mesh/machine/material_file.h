// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// [[material]] of machine.toml.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

Material read_material(const core::Node& node, Draft& draft);

}  // namespace thermotwin::mesh::reader
