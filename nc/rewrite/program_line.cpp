// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/program_line.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

#include "core/character.h"
#include "core/error.h"

namespace thermotwin::nc {

namespace {

using core::is_digit;
using core::is_letter;

constexpr std::size_t chunk_lines = 64;

bool is_space(char c) { return c == ' ' || c == '\t'; }

/// Behind an expression in brackets, or a parameter such as #1, #<name>, ##2.
std::size_t behind_expression(const std::string& text, std::size_t at) {
  int depth = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == '[') ++depth;
    if (c == ']') --depth;
    if (c == '<') {
      at = text.find('>', at);
      if (at == std::string::npos) return text.size();
    }
    ++at;
    if (depth > 0 || c == '#' || c == '-' || c == '+' || is_space(c)) continue;
    if (at < text.size() && (is_digit(text[at]) || text[at] == '.')) continue;
    return at;
  }
  return at;
}

/// Behind an expression that may begin with a function: sin[...], atan[...]/[...]. A name alone ends with itself.
std::size_t behind_function(const std::string& text, std::size_t at) {
  const auto blank = [&](std::size_t from) {
    while (from < text.size() && is_space(text[from])) ++from;
    return from;
  };
  if (!is_letter(text[at])) return behind_expression(text, at);
  while (at < text.size() && is_letter(text[at])) ++at;
  if (const std::size_t open = blank(at); open < text.size() && text[open] == '[') at = behind_expression(text, open);
  const std::size_t slash = blank(at);
  if (slash >= text.size() || text[slash] != '/') return at;
  const std::size_t open = blank(slash + 1);
  return open < text.size() && text[open] == '[' ? behind_expression(text, open) : at;
}

/// Whether an expression stands at a place: [...], #1, -#1, a function.
bool is_expression(const std::string& text, std::size_t at) {
  const auto begins = [&](std::size_t place) {
    return place < text.size() && (text[place] == '[' || text[place] == '#');
  };
  if (at >= text.size()) return false;
  const bool sign = text[at] == '-' || text[at] == '+';
  return begins(at) || is_letter(text[at]) || (sign && begins(at + 1));
}

/// A number, which may have spaces inside: "- 1 . 5". @return the place behind it
std::size_t behind_number(const std::string& text, std::size_t at, double& value) {
  // Nearly all numbers have neither spaces nor a plus inside.
  const auto belongs = [](char c) { return is_digit(c) || c == '.' || c == '-'; };
  std::size_t behind = at;
  while (behind < text.size() && belongs(text[behind])) ++behind;
  std::size_t next = behind;
  while (next < text.size() && is_space(text[next])) ++next;
  if (next == text.size() || !(belongs(text[next]) || text[next] == '+')) {
    std::from_chars(text.data() + at, text.data() + behind, value);
    return behind;
  }
  std::string number;
  std::size_t stop = at;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (is_space(c)) continue;
    if (!belongs(c) && c != '+') break;
    if (c != '+') number += c;
    stop = at + 1;
  }
  std::from_chars(number.data(), number.data() + number.size(), value);
  return stop;
}

/// The word whose letter stands at a place.
Word word_at(const std::string& text, std::size_t begin) {
  Word word;
  word.letter = core::upper(text[begin]);
  word.begin = begin;
  std::size_t at = begin + 1;
  while (at < text.size() && is_space(text[at])) ++at;
  word.expression = is_expression(text, at);
  word.end = word.expression ? behind_function(text, at) : behind_number(text, at, word.value);
  return word;
}

}  // namespace

ProgramLine ProgramLine::parse(std::string text, std::string end) {
  ProgramLine line;
  line.text = std::move(text);
  line.end = std::move(end);
  line.read_words();
  return line;
}

void ProgramLine::read_words() {
  words.clear();
  code_end = 0;
  control = assigns = label = false;
  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == ';') break;
    if (c == '#') {
      assigns = true;
      break;
    }
    if (c == '(') {
      at = text.find(')', at);
      if (at == std::string::npos) break;
      ++at;
    } else if (!is_letter(c) && c != '@' && c != '^') {
      ++at;
      if (!is_space(c)) code_end = at;
    } else if (core::upper(c) == 'O') {
      const std::size_t behind = std::min(text.find_first_not_of("0123456789 \t", at + 1), text.size());
      label = behind == text.size() || text[behind] == '(' || text[behind] == ';';
      control = !label;
      break;
    } else {
      words.push_back(word_at(text, at));
      at = code_end = words.back().end;
    }
  }
}

const Word* ProgramLine::find(char letter) const {
  const auto found = std::find_if(words.begin(), words.end(), [&](const Word& word) { return word.letter == letter; });
  return found == words.end() ? nullptr : &*found;
}

bool ProgramLine::has(char letter, double number) const {
  return std::any_of(words.begin(), words.end(), [&](const Word& word) {
    return word.letter == letter && !word.expression && std::abs(word.value - number) < 1e-6;
  });
}

void ProgramLine::set(char letter, const std::string& number, const std::string& after) {
  if (const Word* found = find(letter)) {
    const Word old = *found;
    text.replace(old.begin + 1, old.end - old.begin - 1, number);
    if (!old.expression && move_words(old.begin, old.begin + 1 + number.size() - old.end)) return;
  } else {
    const Word* last = nullptr;
    for (const Word& candidate : words)
      if (after.find(candidate.letter) != std::string::npos) last = &candidate;
    const std::size_t at = last != nullptr ? last->end : code_end;
    text.insert(at, (at > 0 ? " " : "") + std::string(1, letter) + number);
  }
  read_words();
}

/// Places of words behind one whose number has changed.
/// @param shift  of what follows, modulo 2^64  @return false if the number does not end where the others begin
bool ProgramLine::move_words(std::size_t begin, std::size_t shift) {
  for (std::size_t k = 0; k < words.size(); ++k) {
    Word& word = words[k];
    if (word.begin > begin) {
      word.begin += shift;
      word.end += shift;
    } else if (word.begin == begin) {
      const std::size_t stop = word.end + shift;
      word = word_at(text, begin);
      if (word.end != stop) return false;
    }
  }
  code_end += shift;
  return true;
}

void ProgramLine::remove(const std::vector<std::pair<char, double>>& unwanted) {
  for (std::size_t k = words.size(); k-- > 0;) {
    const Word word = words[k];
    const bool gone = std::any_of(unwanted.begin(), unwanted.end(), [&](const auto& one) {
      return one.first == word.letter && !word.expression && std::abs(one.second - word.value) < 1e-6;
    });
    if (gone) text.erase(word.begin, word.end - word.begin);
  }
  read_words();
}

void ProgramLine::remove(char letter) {
  while (const Word* word = find(letter)) {
    const std::size_t begin = word->begin;
    text.erase(begin, word->end - begin);
    // One space is left where the word stood between two.
    if (begin > 0 && begin < text.size() && is_space(text[begin]) && is_space(text[begin - 1])) text.erase(begin, 1);
    read_words();
  }
}

std::string nc_number(double value, int decimals) {
  std::string text =
      decimals == 4 ? fmt::format(FMT_COMPILE("{:.4f}"), value) : fmt::format("{:.{}f}", value, decimals);
  while (text.back() == '0' && text[text.size() - 2] != '.') text.pop_back();
  if (text.find_first_not_of("-0.") == std::string::npos) return "0.0";
  return text;
}

ProgramText::ProgramText(const std::string& text) : ProgramText(std::make_unique<std::istringstream>(text), "text") {}

ProgramText ProgramText::of_file(const std::filesystem::path& path) {
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*file) throw core::InputError(path.string(), "cannot be read", "an NC program");
  return ProgramText(std::move(file), path.string());
}

ProgramText::ProgramText(std::unique_ptr<std::istream> in, std::string name)
    : in_(std::move(in)),
      name_(std::move(name)) {
  std::vector<char> part(1 << 16);
  std::streamoff place = 0;
  bool begins = true;
  while (in_->read(part.data(), std::ssize(part)), in_->gcount() > 0) {
    const bool marked = place == 0 && std::string_view(part.data(), in_->gcount()).starts_with(byte_order_mark);
    for (std::streamsize i = 0; i < in_->gcount(); ++i, ++place) {
      if (begins && size_++ % chunk_lines == 0) begins_.push_back(place);
      begins = part[i] == '\n';
    }
    if (marked) begins_.front() = std::ssize(byte_order_mark);
  }
}

void ProgramText::load(std::size_t chunk) const {
  in_->clear();
  in_->seekg(begins_[chunk]);
  lines_.clear();
  std::string line;
  while (lines_.size() < chunk_lines && std::getline(*in_, line)) {
    if (!in_->eof()) line += '\n';
    lines_.push_back(line);
  }
  chunk_ = chunk;
}

std::string ProgramText::raw(std::size_t index) const {
  if (index / chunk_lines != chunk_) load(index / chunk_lines);
  if (index % chunk_lines >= lines_.size())
    throw core::InputError(name_, "became shorter while it was read", "a file that stays as it is");
  return lines_[index % chunk_lines];
}

ProgramLine ProgramText::line(std::size_t index) const {
  std::string whole = raw(index);
  std::size_t code = whole.size();
  if (code > 0 && whole[code - 1] == '\n') --code;
  if (code < whole.size() && code > 0 && whole[code - 1] == '\r') --code;
  std::string end = whole.substr(code);
  whole.resize(code);
  return ProgramLine::parse(std::move(whole), std::move(end));
}

}  // namespace thermotwin::nc
