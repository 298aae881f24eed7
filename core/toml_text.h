// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The text of a TOML file before and beside its parser: what the parser must not see, and what a line is meant to be
// that it does not understand.

#include <cstddef>
#include <string>

namespace thermotwin::core {

/// @param source  for messages  @throws InputError (with line and column) for text that is not UTF-8, and for letters
///   beyond ASCII outside of quotes and comments
void require_toml_text(const std::string& text, const std::string& source);

/// What is meant by a line that is no TOML, as far as its form tells; else "TOML 1.0".
/// @param line_number  from 1  @param description  of the parser
std::string allowed_instead(const std::string& text, std::size_t line_number, const std::string& description);

}  // namespace thermotwin::core
