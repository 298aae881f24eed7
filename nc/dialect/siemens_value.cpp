// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/siemens_value.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/character.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::nc {

using core::InputError;

namespace {

constexpr int deepest = 50;
constexpr double largest = 1e9;

using Function = double (*)(double);
double in_degrees(double radians) { return radians / core::units::deg; }
double square(double x) { return x * x; }

struct Named {
  std::string_view name;
  Function value;
};
constexpr std::array<Named, 13> functions{{
    {"SIN", [](double x) { return std::sin(x * core::units::deg); }},
    {"COS", [](double x) { return std::cos(x * core::units::deg); }},
    {"TAN", [](double x) { return std::tan(x * core::units::deg); }},
    {"ASIN", [](double x) { return in_degrees(std::asin(x)); }},
    {"ACOS", [](double x) { return in_degrees(std::acos(x)); }},
    {"SQRT", [](double x) { return std::sqrt(x); }},
    {"ABS", [](double x) { return std::abs(x); }},
    {"POT", square},
    {"TRUNC", [](double x) { return std::trunc(x); }},
    {"ROUND", [](double x) { return std::round(x); }},
    {"ROUNDUP", [](double x) { return std::ceil(x); }},
    {"LN", [](double x) { return std::log(x); }},
    {"EXP", [](double x) { return std::exp(x); }},
}};

/// Recursive descent: sum, product, factor.
class ValueReader {
public:
  ValueReader(const std::string& text, const SiemensParameters& parameters, const std::string& place)
      : text_(core::upper(text)),
        parameters_(parameters),
        place_(place) {}

  SiemensValue read() {
    static constexpr std::array<std::pair<std::string_view, SiemensSense>, 5> senses{{
        {"AC", SiemensSense::absolute},
        {"IC", SiemensSense::incremental},
        {"DC", SiemensSense::shortest},
        {"ACP", SiemensSense::positive},
        {"ACN", SiemensSense::negative},
    }};
    SiemensValue value;
    const std::string word = word_here();
    for (const auto& [name, sense] : senses) {
      if (word != name) continue;
      value.sense = sense;
      at_ += word.size();
      if (peek() != '(') refuse();
    }
    value.number = sum(0);
    if (peek() != '\0') refuse();
    if (!(std::abs(value.number) <= largest)) refuse();
    return value;
  }

private:
  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  std::string word_here() {
    peek();
    std::size_t end = at_;
    while (end < text_.size() && core::is_letter(text_[end])) ++end;
    return text_.substr(at_, end - at_);
  }
  [[noreturn]] void refuse() const {
    throw InputError(
        place_, "the value '" + text_ + "'",
        fmt::format("a number up to {:g}, or an expression of numbers, R parameters, + - * / DIV MOD, brackets, "
                    "SIN, COS, TAN, ASIN, ACOS, ATAN2, SQRT, ABS, POT, TRUNC, ROUND, ROUNDUP, LN, EXP",
                    largest));
  }

  double sum(int depth) {
    if (depth > deepest) refuse();
    double value = product(depth);
    for (char c = peek(); c == '+' || c == '-'; c = peek()) {
      ++at_;
      const double next = product(depth);
      value += c == '+' ? next : -next;
    }
    return value;
  }
  double product(int depth) {
    double value = factor(depth);
    for (;;) {
      const char c = peek();
      const std::string word = word_here();
      if (c == '*' || c == '/') {
        ++at_;
        const double next = factor(depth);
        value = c == '*' ? value * next : value / next;
      } else if (word == "MOD" || word == "DIV") {
        at_ += word.size();
        const double next = factor(depth);
        value = word == "MOD" ? std::fmod(value, next) : std::trunc(value / next);
      } else {
        return value;
      }
    }
  }
  double factor(int depth) {
    if (depth > deepest) refuse();
    const char c = peek();
    if (c == '-' || c == '+') {
      ++at_;
      const double value = factor(depth + 1);
      return c == '-' ? -value : value;
    }
    if (c == '(') return bracket(depth);
    const std::string word = word_here();
    if (word == "R") {
      ++at_;
      return parameter();
    }
    if (word == "ATAN") {  // ATAN2(y, x)
      at_ += 4;
      if (peek() != '2') refuse();
      ++at_;
      if (peek() != '(') refuse();
      ++at_;
      const double y = sum(depth + 1);
      if (peek() != ',') refuse();
      ++at_;
      const double x = sum(depth + 1);
      if (peek() != ')') refuse();
      ++at_;
      return in_degrees(std::atan2(y, x));
    }
    for (const Named& function : functions) {
      if (word != function.name) continue;
      at_ += word.size();
      if (peek() != '(') refuse();
      return function.value(bracket(depth));
    }
    return number();
  }
  double bracket(int depth) {
    ++at_;
    const double value = sum(depth + 1);
    if (peek() != ')') refuse();
    ++at_;
    return value;
  }
  double parameter() {
    long index = -1;
    const auto read = std::from_chars(text_.data() + at_, text_.data() + text_.size(), index);
    if (read.ec != std::errc() || index < 0) refuse();
    at_ = read.ptr - text_.data();
    const auto found = parameters_.find(index);
    if (found == parameters_.end())
      throw InputError(place_, fmt::format("R{} without a value", index), "R parameters that the program sets before");
    return found->second;
  }
  double number() {
    double value = 0;
    const auto read = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value, std::chars_format::fixed);
    if (read.ec != std::errc()) refuse();
    at_ = read.ptr - text_.data();
    return value;
  }

  std::string text_;
  const SiemensParameters& parameters_;
  const std::string& place_;
  std::size_t at_ = 0;
};

}  // namespace

SiemensValue siemens_value(const std::string& text, const SiemensParameters& parameters, const std::string& place) {
  return ValueReader(text, parameters, place).read();
}

std::string number_text(double value) {
  std::string text = fmt::format("{:.7f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace thermotwin::nc
