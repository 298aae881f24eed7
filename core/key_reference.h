// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reference documentation of a file's keys, from the table that its reader uses.

#include <string>

#include "core/key_table.h"

namespace thermotwin::core {

/// Markdown: a section for the file and for each of its tables, with one line a key.
std::string key_reference(const KeyTable& file);

}  // namespace thermotwin::core
