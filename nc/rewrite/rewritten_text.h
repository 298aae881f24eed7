// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The corrected program as text, made from the lines of the program that run, in their order. A program without loops
// keeps all of its lines. Of another one the lines that run are written one after another, without subprograms,
// branches and parameters.

#include <cstddef>
#include <functional>
#include <string>

#include "nc/rewrite/executed_line.h"

namespace thermotwin::nc {

class RewrittenText {
public:
  /// @param program  must outlive this  @param out  receives the new text in parts
  RewrittenText(const ProgramText& program, std::function<void(const std::string&)> out);

  /// @throws InputError  for what cannot be written out
  void add(const ExecutedLine& entry);
  void finish();
  long lines_after() const { return lines_after_; }  ///< of the new text so far

private:
  void count(const std::string& text);
  void add_flat(const ExecutedLine& entry);

  const ProgramText& lines_;
  std::function<void(const std::string&)> out_;
  long lines_after_ = 0;
  bool flat_ = true;                   ///< every line runs once, in order
  bool began_ = false, code_ = false;  ///< a line, a line with words has left, where it is not flat
  bool ended_ = false;                 ///< a line with M2 or M30 has left, where it is not flat
  std::size_t written_ = 0;            ///< lines of the program that have left, where it is flat
};

}  // namespace thermotwin::nc
