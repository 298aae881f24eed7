// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Laws of losses and contacts of machine.toml; axes must have been read.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

LossLaw read_loss(const core::Node& node, const Draft& draft);

ContactLaw read_contact_law(const core::Node& node, const std::string& axis);

}  // namespace thermotwin::mesh::reader
