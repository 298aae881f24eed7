// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The table of the keys of machine.toml: names, units, ranges, defaults and meaning, for the readers and the reference.

#include "core/key_table.h"

namespace thermotwin::mesh {

const core::KeyTable& machine_keys();

}  // namespace thermotwin::mesh
