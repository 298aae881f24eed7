// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Words of Sinumerik controls by what the translation does with them.

#include <string>

namespace thermotwin::nc {

/// Statements without an effect on the path's geometry as far as `nc` computes it.
bool is_skipped_keyword(const std::string& name);
/// G words that LinuxCNC's interpreter reads in the same sense.
bool is_same_word(int number);
/// Corner and exact stop conditions of the control.
bool is_skipped_word(int number);
/// TRANS and its like, which stand in a line of their own.
bool is_frame(const std::string& name);
/// Jumps, loops, branches and subprograms: without the statement the lines that it governs would run once.
bool is_control_statement(const std::string& word);

}  // namespace thermotwin::nc
