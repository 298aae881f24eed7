// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of a control profile.

#include "core/key_table.h"

namespace thermotwin::nc {

const core::KeyTable& control_keys();

}  // namespace thermotwin::nc
