// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/rewritten_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/text.h"

namespace thermotwin::nc {

namespace {

bool is_percent(const ProgramText& lines, std::size_t index) {
  const std::string line = lines.raw(index);
  return core::trimmed(line) == "%";
}

/// The last line that is not blank; 0: there is none behind the first.
std::size_t last_line(const ProgramText& lines) {
  std::size_t last = lines.size() - 1;
  for (std::string line; last > 0; --last) {
    line = lines.raw(last);
    if (!core::trimmed(line).empty()) break;
  }
  return last;
}

}  // namespace

RewrittenText::RewrittenText(const ProgramText& program, std::function<void(const std::string&)> out)
    : lines_(program),
      out_(std::move(out)) {
  for (std::size_t i = 0; i < lines_.size() && flat_; ++i) {
    const ProgramLine line = lines_.line(i);
    flat_ = !(line.control || line.assigns || line.has('M', 98) || line.has('M', 99));
  }
}

void RewrittenText::count(const std::string& text) {
  lines_after_ += std::count(text.begin(), text.end(), '\n');
  out_(text);
}

/// A program without loops keeps all of its lines, also those that the interpreter does not read.
void RewrittenText::add_flat(const ExecutedLine& entry) {
  while (written_ + 1 < entry.number && written_ < lines_.size()) {
    count(lines_.raw(written_));
    ++written_;
  }
  if (entry.number != written_ + 1) return;  // the end of the program is read twice
  written_ = entry.number;
  count(entry.modes.cycle && entry.expected > 0 ? entry.before : entry.text + entry.line.end);
}

void RewrittenText::add(const ExecutedLine& entry) {
  if (flat_) {
    add_flat(entry);
    return;
  }
  const std::string end = entry.line.end.empty() ? "\n" : entry.line.end;
  if (!began_) {
    // Lines before the first one that the interpreter reads, such as %.
    for (std::size_t i = 0; i + 1 < entry.number && i < lines_.size(); ++i) count(lines_.raw(i));
    began_ = true;
  }
  const bool words = std::any_of(entry.line.words.begin(), entry.line.words.end(),
                                 [](const Word& word) { return word.letter != 'N'; });
  if (entry.line.assigns && words && !entry.skipped)
    refuse_path(entry.place, "a parameter that is set in a line with other words", "a line of its own for it");
  if (entry.line.control || entry.line.assigns || entry.line.has('M', 98) || entry.line.has('M', 99)) return;
  if (entry.skipped && !entry.line.words.empty()) return;
  if (entry.line.label && code_) return;  // of a subprogram
  code_ = code_ || !entry.line.words.empty();
  if (entry.expected == 0)
    for (const Word& word : ProgramLine::parse(entry.text, "").words)
      if (word.expression)
        refuse_path(entry.place, fmt::format("an expression at {} of a line without a move", word.letter), "a number");
  if (entry.number == 0) return;
  ended_ = ended_ || entry.line.has('M', 2) || entry.line.has('M', 30);
  count(entry.modes.cycle && entry.expected > 0 ? entry.before : entry.text + end);
}

void RewrittenText::finish() {
  if (flat_) {
    for (; written_ < lines_.size(); ++written_) {
      out_(lines_.raw(written_));
      ++lines_after_;
    }
  } else {
    const bool percent =
        began_ && is_percent(lines_, 0) && last_line(lines_) > 0 && is_percent(lines_, last_line(lines_));
    // A main program may end with M99, which goes with the subprograms.
    if (percent || !ended_) {
      out_(percent ? "%\n" : "M2\n");
      ++lines_after_;
    }
  }
}

}  // namespace thermotwin::nc
