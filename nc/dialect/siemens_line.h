// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A line of a program in the language of Sinumerik controls (DIN 66025 with extended addresses) as its statements.
// Labels, block numbers and comments are left out.

#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::nc {

/// X10, X=AC(R1 + 2), S1=3000, CR=5, TRANS, CYCLE832(0.01, 1), R5=7.
struct SiemensStatement {
  std::string name;       ///< upper case: X, S1 (extended address), CR, TRANS
  std::string value;      ///< text behind the name, or behind "="; empty: none
  std::string arguments;  ///< between the brackets behind a keyword
  bool assigned = false;  ///< with "="
  bool called = false;    ///< with brackets

  bool is_letter() const { return name.size() == 1; }
  std::string text() const;  ///< as it stands, for messages
};

struct SiemensLine {
  bool skip_mark = false;  ///< "/": left out where the operator wants it
  std::vector<SiemensStatement> statements;
};

/// @param place  file:line, for messages  @throws InputError for text that is no statement
SiemensLine parse_siemens_line(std::string_view text, const std::string& place);

}  // namespace thermotwin::nc
