// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/toml_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "core/character.h"
#include "core/error.h"
#include "core/text.h"

namespace thermotwin::core {

namespace {

/// "4:7" for an offset; columns count bytes.
std::string line_and_column(const std::string& text, std::size_t offset) {
  const auto line = 1 + std::count(text.begin(), text.begin() + offset, '\n');
  const std::size_t before = offset == 0 ? std::string::npos : text.rfind('\n', offset - 1);
  const std::size_t column = before == std::string::npos ? offset + 1 : offset - before;
  return fmt::format("{}:{}", line, column);
}

}  // namespace

void require_toml_text(const std::string& text, const std::string& source) {
  // The parser is not safe on broken UTF-8, so it never sees any.
  if (const auto offset = find_invalid_utf8(text)) {
    throw InputError(source + ":" + line_and_column(text, *offset), fmt::format("byte {:#04x}", byte_of(text[*offset])),
                     "text in UTF-8");
  }
  // Nor letters where TOML has none: it takes some of them for an impossible case.
  if (const auto offset = find_bare_non_ascii(text)) {
    throw InputError(source + ":" + line_and_column(text, *offset),
                     fmt::format("byte {:#04x} outside of quotes and comments", byte_of(text[*offset])),
                     "ASCII there; other letters in quotes");
  }
}

std::string allowed_instead(const std::string& text, std::size_t line_number, const std::string& description) {
  std::size_t begin = 0;
  for (std::size_t line = 1; line < line_number && begin != std::string::npos; ++line) {
    begin = text.find('\n', begin);
    if (begin != std::string::npos) ++begin;
  }
  if (begin == std::string::npos) return "TOML 1.0";
  const std::string line = text.substr(begin, text.find('\n', begin) - begin);
  std::smatch found;
  static const std::regex comma(R"(^\s*([\w.-]+)\s*=\s*([-+]?\d+),(\d+)\s*(#.*)?$)");
  if (std::regex_search(line, found, comma))
    return fmt::format("a decimal point: {} = {}.{}", found[1].str(), found[2].str(), found[3].str());
  static const std::regex bare(R"(^\s*([\w.-]+)\s*=\s*([A-Za-z_][\w.-]*)\s*(#.*)?$)");
  static const std::regex truth(R"(^\s*([\w.-]+)\s*=\s*(?:([Tt][Rr][Uu][Ee])|[Ff][Aa][Ll][Ss][Ee])\s*(#.*)?$)");
  if (std::regex_search(line, found, truth))
    return fmt::format("small letters: {} = {}", found[1].str(), found[2].matched ? "true" : "false");
  if (std::regex_search(line, found, bare))
    return fmt::format("a text in quotes: {} = \"{}\"", found[1].str(), found[2].str());
  static const std::regex header(R"(^\s*\[\s*([\w.-]+)\s*\]\s*(#.*)?$)");
  if (std::regex_search(line, found, header) && description.find("redefine") != std::string::npos)
    return fmt::format("each [table] once; of several ones [[{}]] each", found[1].str());
  return "TOML 1.0";
}

}  // namespace thermotwin::core
