// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// The tool table that the interpreter asks the host for.

#include <emctool.h>
#include <vector>

namespace thermotwin::nc::rs274 {

/// Entry 0 is the spindle; the others are the tools of the job.
std::vector<CANON_TOOL_TABLE>& tool_table();
CANON_TOOL_TABLE no_tool();
void add_tool(const CANON_TOOL_TABLE& tool);
/// Puts the tool of an entry into the spindle; 0: none.
void load_tool(int entry);

}  // namespace thermotwin::nc::rs274
