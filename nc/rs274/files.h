// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// The files that the interpreter sees. The library's calls of fopen, rename, unlink and the like come here first: it
// reads regular files below the program's folder, and writes none. A file is handed on with the words of the control
// profile replaced, line by line, so that line numbers stay.

#include <string>
#include <vector>

namespace thermotwin::nc::rs274 {

/// A word (letter and number) with what stands in its place: nothing, or other words and a marker.
struct Rule {
  enum class Action { skip, replace, refuse } action;
  char letter;         ///< upper case
  double number;       ///< of the word
  std::string second;  ///< letters of words that go with it: "H"
  std::string text;    ///< replacement: words, then a comment for a marker; reason of a refusal
};

/// From here on files are guarded. @param fanuc  words have the meaning that they have on Fanuc controls
void guard_files(const std::string& folder, std::vector<Rule> rules, bool fanuc);
/// A file outside of the folder that was asked for, or empty.
const std::string& refused_file();

/// A line with its words replaced and a marker behind the comments, which stay.
/// @throws std::string  for a word that is refused
std::string rewritten_line(const std::string& line, const std::vector<Rule>& rules);

}  // namespace thermotwin::nc::rs274
