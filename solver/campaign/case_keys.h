// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The table of the keys of case.toml.

#include "core/key_table.h"

namespace thermotwin::solver {

const core::KeyTable& case_keys();

}  // namespace thermotwin::solver
