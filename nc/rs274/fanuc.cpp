// SPDX-License-Identifier: GPL-2.0-or-later
#include "nc/rs274/fanuc.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <vector>

namespace thermotwin::nc::rs274 {

namespace {

constexpr long first_system_variable = 1000;

/// The line with blanks in place of its comments.
std::string code_of(const std::string& line) {
  std::string code = line;
  bool comment = false;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == ';' && !comment) {
      std::fill(code.begin() + i, code.end(), ' ');
      break;
    }
    const bool closes = comment && code[i] == ')';
    comment = comment || code[i] == '(';
    if (comment) code[i] = ' ';
    if (closes) comment = false;
  }
  return code;
}

struct Word {
  char letter;
  std::size_t begin, value, end;  ///< of the letter; of what follows it
  std::string text;               ///< the value without blanks
  bool expression;
  double number() const { return std::strtod(text.c_str(), nullptr); }
};

/// Behind a bracket that opens at a place.
std::size_t behind_bracket(const std::string& code, std::size_t at) {
  int depth = 0;
  for (; at < code.size(); ++at) {
    depth += code[at] == '[' ? 1 : code[at] == ']' ? -1 : 0;
    if (depth == 0) return at + 1;
  }
  return at;
}

std::size_t behind_value(const std::string& code, std::size_t at) {
  while (at < code.size() && (code[at] == '#' || code[at] == '-' || code[at] == '+')) ++at;
  if (at < code.size() && code[at] == '[') return behind_bracket(code, at);
  while (at < code.size() && (std::isdigit(static_cast<unsigned char>(code[at])) != 0 || code[at] == '.')) ++at;
  return at;
}

std::vector<Word> words_of(const std::string& code) {
  std::vector<Word> words;
  for (std::size_t i = 0; i < code.size();) {
    const auto c = static_cast<unsigned char>(code[i]);
    if (c == '#' || c == '[') {  // of no word: an assignment
      i = std::max(behind_value(code, i), i + 1);
      continue;
    }
    if (std::isalpha(c) == 0) {
      ++i;
      continue;
    }
    Word word{static_cast<char>(std::toupper(c)), i, i + 1, 0, "", false};
    while (word.value < code.size() && code[word.value] == ' ') ++word.value;
    word.end = behind_value(code, word.value);
    word.text = code.substr(word.value, word.end - word.value);
    word.expression = word.text.find_first_of("#[") != std::string::npos;
    i = std::max(word.end, i + 1);
    words.push_back(word);
  }
  return words;
}

bool has(const std::vector<Word>& words, char letter, std::initializer_list<double> numbers) {
  return std::any_of(words.begin(), words.end(), [&](const Word& word) {
    return word.letter == letter && !word.expression && !word.text.empty() &&
           std::any_of(numbers.begin(), numbers.end(),
                       [&](double number) { return std::abs(number - word.number()) < 1e-6; });
  });
}

const Word* find(const std::vector<Word>& words, char letter) {
  const auto found = std::find_if(words.begin(), words.end(), [&](const Word& word) { return word.letter == letter; });
  return found == words.end() ? nullptr : &*found;
}

/// A value in ms as the word P in s.
std::string seconds(const Word& word) {
  if (word.expression) return "P[" + word.text + "/1000]";
  if (word.text.find('.') != std::string::npos)
    throw "P" + word.text + " of a dwell\tP in whole milliseconds (P1500), or X or U in seconds (X1.5)";
  char text[64];
  std::snprintf(text, sizeof text, "P%.6f", word.number() / 1000.0);
  return text;
}

void require_offset(const std::vector<Word>& words, bool incremental) {
  const Word *l = find(words, 'L'), *p = find(words, 'P');
  if (l == nullptr || l->expression || l->number() != 2)
    throw "G10 " + (l != nullptr ? "L" + l->text : std::string("without L")) +
        "\tG10 L2 P1 to P6; lengths of tools as [[tool]] of the control profile (--control) or as a table (--tools)";
  if (p == nullptr || (!p->expression && !(p->number() >= 1 && p->number() <= 6)))
    throw "G10 L2 P" + (p != nullptr ? p->text : std::string()) + "\tthe work offsets P1 to P6";
  if (incremental) throw std::string("G10 L2 with G91, which adds to the offset\tG90 before it");
}

/// Number behind a '#'; -1: none. @param at  behind the '#', then behind the number
long variable(const std::string& code, std::size_t& at) {
  while (at < code.size() && code[at] == ' ') ++at;
  const std::size_t first = at;
  while (at < code.size() && std::isdigit(static_cast<unsigned char>(code[at])) != 0) ++at;
  return at == first ? -1 : std::strtol(code.substr(first, std::min<std::size_t>(at - first, 9)).c_str(), nullptr, 10);
}

bool is_set_here(const std::string& code, std::size_t at) {
  while (at < code.size() && code[at] == ' ') ++at;
  return at < code.size() && code[at] == '=';
}

}  // namespace

void FanucText::see(const std::string& line) {
  const std::string code = code_of(line);
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] != '#') continue;
    std::size_t at = i + 1;
    const long number = variable(code, at);
    const bool computed = number < 0 && at < code.size() && code[at] == '[';
    if (computed) at = behind_bracket(code, at);
    if (!is_set_here(code, at)) continue;
    if (computed) set_by_number_ = true;
    if (number >= 0) set_.insert(number);
  }
  std::string small = code;
  std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return std::tolower(c); });
  if (small.find("call") != std::string::npos) set_by_number_ = true;
}

void FanucText::require_variables(const std::string& code) const {
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] != '#') continue;
    std::size_t at = i + 1;
    const long number = variable(code, at);
    if (number >= first_system_variable)
      throw "#" + std::to_string(number) + ", a system variable\tvariables #1 to #999 that the program sets";
    if (number < 0 && at < code.size() && code[at] == '[') {
      const std::string inside = code.substr(at, behind_bracket(code, at) - at);
      for (std::size_t k = 0; k < inside.size(); ++k) {
        const long part = variable(inside, k);
        if (part >= first_system_variable)
          throw "#" + inside + ", a system variable\tvariables #1 to #999 that the program sets";
      }
    }
    if (number > 0 && !set_by_number_ && !is_set_here(code, at) && set_.count(number) == 0)
      throw "#" + std::to_string(number) +
          ", which the program sets nowhere; the control leaves out the word of an empty variable\tvariables that it "
          "sets";
  }
}

std::string FanucText::line(const std::string& line) {
  const std::string code = code_of(line);
  require_variables(code);
  const std::vector<Word> words = words_of(code);
  if (has(words, 'G', {91})) incremental_ = true;
  if (has(words, 'G', {90})) incremental_ = false;
  if (has(words, 'G', {0, 1, 2, 3, 80})) cycle_ = false;
  const bool begins = has(words, 'G', {73, 74, 76, 81, 82, 83, 84, 85, 86, 87, 88, 89});
  cycle_ = cycle_ || begins;
  if (has(words, 'G', {10})) require_offset(words, incremental_);
  const bool dwell = has(words, 'G', {4});
  // These have a P of their own.
  const bool other = has(words, 'G', {5, 5.1, 8, 10, 30, 54.1, 65, 66}) || has(words, 'M', {97, 98, 99});
  if (!dwell && (!cycle_ || other)) return line;
  std::string out = line;
  for (std::size_t k = words.size(); k-- > 0;) {  // from behind, so that places hold
    const Word& word = words[k];
    const auto put = [&](const std::string& text) { out.replace(word.begin, word.end - word.begin, text); };
    if (word.letter == 'P') put(seconds(word));
    if (dwell && (word.letter == 'X' || word.letter == 'U')) {
      if (!word.expression && word.text.find('.') == std::string::npos)
        throw "G4 " + (word.letter + word.text) + "\tseconds with a decimal point (X1.0), or P in milliseconds";
      put("P" + word.text);
    }
  }
  return out;
}

}  // namespace thermotwin::nc::rs274
