// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine whose joints are held at more places.

#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// Joints divided so many times as finely, where they are divided at all: contact from point to point is the limit.
/// A direction of one cell stays one, since a joint may be meant to turn there. @param times  at least 1
Machine with_finer_pads(Machine machine, int times);

/// Whether any joint that holds a body is divided; pads have no influence on heat.
bool has_divided_pads(const Machine& machine);

}  // namespace thermotwin::mesh
