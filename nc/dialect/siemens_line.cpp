// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/siemens_line.h"

#include <fmt/format.h>

#include "core/character.h"
#include "core/error.h"
#include "core/text.h"

namespace thermotwin::nc {

using core::InputError;
using core::is_digit;

namespace {

bool is_alpha(char c) { return core::is_letter(c) || c == '_' || c == '$'; }
bool is_operator(char c) { return c == '+' || c == '-' || c == '*' || c == '/'; }
/// MOD and DIV are operators as well.
bool is_named_operator(std::string_view text) {
  const std::string name = core::upper(text.substr(0, 3));
  return (name == "MOD" || name == "DIV") && (text.size() == 3 || !is_alpha(text[3]));
}

class LineReader {
public:
  LineReader(std::string_view text, const std::string& place) : text_(text), place_(place) {}

  SiemensLine read() {
    SiemensLine line;
    skip_blanks();
    if (at_ == 0 && peek() == '%') return line;  // %_N_NAME_MPF: the program's name
    if (peek() == '/') {
      line.skip_mark = true;
      ++at_;
      while (is_digit(peek())) ++at_;
    }
    for (skip_blanks(); !ended(); skip_blanks()) {
      if (peek() == ':') {  // main block number
        ++at_;
        while (is_digit(peek())) ++at_;
        continue;
      }
      if (!is_alpha(peek())) refuse(std::string(text_.substr(at_)));
      if (line.statements.empty() && skip_label()) continue;
      SiemensStatement statement = read_statement();
      if (statement.name != "N") line.statements.push_back(std::move(statement));
    }
    return line;
  }

private:
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool ended() const { return at_ >= text_.size() || text_[at_] == ';'; }
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r')) ++at_;
  }
  [[noreturn]] void refuse(const std::string& value) const {
    throw InputError(place_, "'" + value + "'", "words such as X10, X=AC(5), CR=5, TRANS X10, TRAORI");
  }

  /// L1: and START_2: mark a block.
  bool skip_label() {
    std::size_t end = at_;
    while (end < text_.size() && (is_alpha(text_[end]) || is_digit(text_[end]))) ++end;
    if (end == text_.size() || text_[end] != ':') return false;
    at_ = end + 1;
    return true;
  }

  SiemensStatement read_statement() {
    SiemensStatement statement;
    std::size_t letters = at_;
    while (letters < text_.size() && is_alpha(text_[letters])) ++letters;
    std::size_t end = letters;
    while (end < text_.size() && (is_alpha(text_[end]) || is_digit(text_[end]))) ++end;
    const std::size_t first = at_;
    if (letters - at_ == 1) {
      std::size_t digits = letters;
      while (digits < text_.size() && is_digit(text_[digits])) ++digits;
      std::size_t next = digits;
      while (next < text_.size() && text_[next] == ' ') ++next;
      const bool extended = digits > letters && next < text_.size() && text_[next] == '=';
      at_ = extended ? digits : letters;
      statement.name = core::upper(text_.substr(first, at_ - first));
      skip_blanks();
      if (peek() == '=') return read_assigned(std::move(statement));
      read_number(statement);
      return statement;
    }
    at_ = end;
    statement.name = core::upper(text_.substr(first, end - first));
    skip_blanks();
    if (peek() == '=') return read_assigned(std::move(statement));
    if (peek() == '(') {
      statement.called = true;
      statement.arguments = read_brackets();
    }
    return statement;
  }

  void read_number(SiemensStatement& statement) {
    const std::size_t first = at_;
    if (peek() == '+' || peek() == '-') ++at_;
    while (is_digit(peek()) || peek() == '.') ++at_;
    statement.value = std::string(text_.substr(first, at_ - first));
  }

  SiemensStatement read_assigned(SiemensStatement statement) {
    ++at_;
    statement.assigned = true;
    skip_blanks();
    // A value goes on behind blanks only where an operator stands before or behind them.
    while (!ended()) {
      if (peek() == '(') {
        statement.value += '(' + read_brackets() + ')';
      } else if (peek() == '"') {
        statement.value += read_quoted();
      } else if (peek() == ' ' || peek() == '\t' || peek() == '\r') {
        skip_blanks();
        const std::string& value = statement.value;
        const bool open = !value.empty() && (is_operator(value.back()) ||
                                             (value.size() > 3 && is_named_operator(value.substr(value.size() - 3))));
        if (ended() || !(open || is_operator(peek()) || is_named_operator(text_.substr(at_)))) break;
      } else {
        statement.value += peek();
        ++at_;
      }
    }
    if (statement.value.empty()) refuse(statement.name + "=");
    return statement;
  }

  /// What stands between the brackets that open here.
  std::string read_brackets() {
    const std::size_t first = ++at_;
    int depth = 1;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '"') {
        read_quoted();
        --at_;
        continue;
      }
      depth += text_[at_] == '(' ? 1 : text_[at_] == ')' ? -1 : 0;
      if (depth == 0) return std::string(text_.substr(first, at_++ - first));
    }
    throw InputError(place_, "'(' without ')'", "a bracket that closes");
  }

  std::string read_quoted() {
    const std::size_t first = at_++;
    while (at_ < text_.size() && text_[at_] != '"') ++at_;
    if (at_ == text_.size()) throw InputError(place_, "'\"' without an end", "a text that ends with '\"'");
    return std::string(text_.substr(first, ++at_ - first));
  }

  std::string_view text_;
  const std::string& place_;
  std::size_t at_ = 0;
};

}  // namespace

std::string SiemensStatement::text() const {
  return name + (assigned ? "=" : "") + value + (called ? "(" + arguments + ")" : "");
}

SiemensLine parse_siemens_line(std::string_view text, const std::string& place) {
  return LineReader(text, place).read();
}

}  // namespace thermotwin::nc
