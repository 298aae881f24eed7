// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The table of the keys of a plan for `study variants`.

#include "core/key_table.h"

namespace thermotwin::study {

const core::KeyTable& variant_plan_keys();

}  // namespace thermotwin::study
