// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of machine.toml for ambients, doors, volumes, films, coolants and heat sources.

#include "core/key_table.h"

namespace thermotwin::mesh {

/// Bounds of values that several tables have.
namespace range {
inline constexpr core::Range share{0.0, 1.0};
inline constexpr core::Range specific_heat{10.0, 20000.0};  ///< J/(kg K)
}  // namespace range

const core::KeyTable& ambient_keys();
const core::KeyTable& door_keys();
const core::KeyTable& volume_keys();
const core::KeyTable& film_keys();
const core::KeyTable& coolant_keys();
const core::KeyTable& source_keys();

}  // namespace thermotwin::mesh
