// SPDX-License-Identifier: GPL-2.0-or-later
#include "nc/rs274/tools.h"

namespace thermotwin::nc::rs274 {

CANON_TOOL_TABLE no_tool() {
  CANON_TOOL_TABLE tool{};
  tool.toolno = -1;
  tool.pocketno = -1;
  return tool;
}

std::vector<CANON_TOOL_TABLE>& tool_table() {
  static std::vector<CANON_TOOL_TABLE> table = [] {
    CANON_TOOL_TABLE empty = no_tool();
    empty.toolno = 0;
    empty.pocketno = 0;
    return std::vector<CANON_TOOL_TABLE>{empty};
  }();
  return table;
}

void add_tool(const CANON_TOOL_TABLE& tool) { tool_table().push_back(tool); }

void load_tool(int entry) {
  std::vector<CANON_TOOL_TABLE>& table = tool_table();
  CANON_TOOL_TABLE tool = no_tool();
  tool.toolno = 0;
  if (entry > 0 && entry < std::ssize(table)) tool = table[entry];
  tool.pocketno = entry > 0 ? entry : 0;
  table[0] = tool;
}

}  // namespace thermotwin::nc::rs274

// What the library calls; 0 is success.
int tooldata_get(CANON_TOOL_TABLE* tool, int entry) {
  const auto& table = thermotwin::nc::rs274::tool_table();
  if (entry < 0 || entry >= std::ssize(table)) {
    *tool = thermotwin::nc::rs274::no_tool();
    return entry < 0 || entry >= CANON_POCKETS_MAX ? 2 : 0;
  }
  *tool = table[entry];
  return 0;
}

int tooldata_find_index_for_tool(int number) {
  const auto& table = thermotwin::nc::rs274::tool_table();
  if (number == 0) return 0;
  for (std::size_t i = 1; i < table.size(); ++i)
    if (table[i].toolno == number) return i;
  return -1;
}

CANON_TOOL_TABLE tooldata_entry_init() { return thermotwin::nc::rs274::no_tool(); }
