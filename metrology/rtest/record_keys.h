// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of rtest.toml, which describes the points of an R-Test.

#include "core/key_table.h"

namespace thermotwin::metrology {

const core::KeyTable& record_keys();

}  // namespace thermotwin::metrology
