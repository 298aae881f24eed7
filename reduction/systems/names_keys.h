// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of names.toml. The file stands beside matrices of another program and gives names, units and values to films
// (matrices), inputs (columns of B) and outputs (rows of C).

#include "core/key_table.h"

namespace thermotwin::reduction {

const core::KeyTable& names_keys();

}  // namespace thermotwin::reduction
