// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of machine.toml: names, units, ranges, defaults and meaning. The readers take them from here.

#include "core/key_table.h"

namespace thermotwin::mesh {

const core::KeyTable& machine_keys();

}  // namespace thermotwin::mesh
