// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the laws of losses and contacts of machine.toml. The axes must have been read before.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// @throws InputError naming file, line and key
LossLaw read_loss(const core::Node& node, const Draft& draft);

/// @param axis  of the joint; empty if it does not move  @throws InputError naming file, line and key
ContactLaw read_contact_law(const core::Node& node, const std::string& axis);

}  // namespace thermotwin::mesh::reader
