// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What can only be seen on the whole machine.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

void check_references(const Draft& draft);

void check_machine(const Draft& draft);

}  // namespace thermotwin::mesh::reader
