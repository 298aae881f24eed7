// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The keys of channels.toml, which says what each column of a measurement is.

#include "core/key_table.h"

namespace thermotwin::compensation {

const core::KeyTable& channel_keys();

}  // namespace thermotwin::compensation
