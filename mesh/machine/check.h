// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Checks of a machine that need all of its tables.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// @throws InputError for an id that no table defines, with the nearest known one
void check_references(const Draft& draft);

/// Checks parents and axes, joints, scales, screws, surfaces and films against each other. @throws InputError
void check_machine(const Draft& draft);

}  // namespace thermotwin::mesh::reader
