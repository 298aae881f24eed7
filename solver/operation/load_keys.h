// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of load programs, loads/*.toml, and of [time], which case.toml has as well.

#include "core/key_table.h"

namespace thermotwin::solver {

const core::KeyTable& load_keys();
const core::KeyTable& time_keys();

}  // namespace thermotwin::solver
