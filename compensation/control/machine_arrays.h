// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine in the arrays of the online core: channels, ambients, films, joints, coolants, sources, chains.

#include "compensation/control/control_data.h"
#include "mesh/machine/machine.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {

/// Fills what follows from machine.toml and the layout. @throws InputError for an id that the machine does not have
void fill_machine(const mesh::Machine& machine, const solver::Layout& layout, const solver::Channels& channels,
                  ControlData& data);

}  // namespace thermotwin::compensation
