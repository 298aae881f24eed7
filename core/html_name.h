// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Names and poses in the markup of pages.

#include <string>
#include <string_view>

namespace thermotwin::core {

/// @param escaped  text without tags, as of xml_text()
/// @return the same; a line may end after its underscores and commas
inline std::string breakable(std::string_view escaped) {
  std::string markup;
  for (const char c : escaped) {
    markup += c;
    if (c == '_' || c == ',') markup += "<wbr>";
  }
  return markup;
}

}  // namespace thermotwin::core
