// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of names.toml, which names what the matrices of a foreign system belong to.

#include "core/key_table.h"

namespace thermotwin::reduction {

const core::KeyTable& names_keys();

}  // namespace thermotwin::reduction
