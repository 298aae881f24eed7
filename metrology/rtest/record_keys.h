// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of rtest.toml and of grid.toml, which describe the points of an R-Test and of a volumetric grid.

#include "core/key_table.h"

namespace thermotwin::metrology {

const core::KeyTable& record_keys();
const core::KeyTable& grid_keys();

}  // namespace thermotwin::metrology
