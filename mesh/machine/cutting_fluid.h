// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tests if a machine's description uses the cutting fluid.

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// @return whether a film, an exchange of a volume or a source listens to the channel "cutting_fluid.on"
bool has_cutting_fluid(const Machine& machine);

}  // namespace thermotwin::mesh
