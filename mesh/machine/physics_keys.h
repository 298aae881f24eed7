// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of machine.toml for what heats and cools the machine.

#include "core/key_table.h"

namespace thermotwin::mesh {

const core::KeyTable& ambient_keys();
const core::KeyTable& door_keys();
const core::KeyTable& volume_keys();
const core::KeyTable& film_keys();
const core::KeyTable& coolant_keys();
const core::KeyTable& source_keys();

}  // namespace thermotwin::mesh
