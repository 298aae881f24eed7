// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/page_text.h"

#include <fmt/format.h>

#include "core/character.h"

namespace thermotwin::core {

std::string unit_text(std::string_view unit) {
  if (unit == "degC") return "°C";
  if (unit == "W/m2") return "W/m²";
  if (unit == "um" || unit.starts_with("um/")) return "µ" + std::string(unit.substr(1));
  return std::string(unit);
}

std::string json_text(std::string_view text) {
  std::string safe = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      safe += {'\\', c};
    } else if (byte_of(c) < 0x20 || c == '<' || c == '>') {
      safe += fmt::format("\\u{:04x}", c);
    } else {
      safe += c;
    }
  }
  return safe + '"';
}

}  // namespace thermotwin::core
