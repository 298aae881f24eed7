// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of an uncertainty budget.

#include "core/key_table.h"

namespace thermotwin::metrology {

const core::KeyTable& budget_keys();

}  // namespace thermotwin::metrology
