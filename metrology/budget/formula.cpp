// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/formula.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <numbers>

#include "core/error.h"
#include "core/text.h"

namespace thermotwin::metrology {

using core::InputError;

namespace {

constexpr std::size_t longest = 2000;  ///< characters
constexpr const char* allowed = "a formula such as \"V / I * cos(phi)\"";

/// A single = would assign a value to a quantity; ==, <=, >= and != compare.
bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
    } else if (i == 0 || std::string("<>!").find(text[i - 1]) == std::string::npos) {
      return true;
    }
  }
  return false;
}

bool printable(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return (c >= ' ' && c <= '~') || c == '\n' || c == '\t'; });
}

}  // namespace

struct Formula::Parser {
  mu::Parser parser;
  mutable std::vector<double> values;
  std::vector<std::size_t> used;
};

Formula::Formula(const std::string& text, const std::vector<std::string>& names, const std::string& place)
    : parser_(std::make_unique<Parser>()) {
  if (core::trimmed(text).empty()) throw InputError(place, "an empty formula", allowed);
  if (text.size() > longest)
    throw InputError(place, fmt::format("{} characters", text.size()), fmt::format("at most {}", longest));
  if (!printable(text) || text.find_first_of("\"#") != std::string::npos)
    throw InputError(place, "a character that no formula has", allowed);
  if (assigns(text)) throw InputError(place, "'=' in '" + text + "'", "no assignment: comparisons are == <= >= !=");
  parser_->values.assign(names.size(), 1.0);
  mu::Parser& parser = parser_->parser;
  try {
    parser.DefineConst("pi", std::numbers::pi);
    for (std::size_t i = 0; i < names.size(); ++i) parser.DefineVar(names[i], &parser_->values[i]);
    parser.SetExpr(text);
    int count = 0;
    parser.Eval(count);
    if (count != 1)
      throw InputError(place, fmt::format("{} values from '{}'", count, text),
                       "one value: no comma outside of functions");
    for (const auto& [name, variable] : parser.GetUsedVar())
      parser_->used.push_back(std::find(names.begin(), names.end(), name) - names.begin());
    std::sort(parser_->used.begin(), parser_->used.end());
  } catch (const mu::Parser::exception_type& error) {
    const std::string token = error.GetToken();
    if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN && !token.empty()) {
      throw InputError(place, "'" + token + "' in '" + text + "'",
                       "names of the budget: " + core::join(names) + " (nearest: " + core::nearest(token, names) + ")");
    }
    throw InputError(place, "'" + text + "': " + error.GetMsg(), allowed);
  }
}

Formula::~Formula() = default;
Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;

double Formula::operator()(const double* values) const {
  std::copy(values, values + std::ssize(parser_->values), parser_->values.begin());
  return parser_->parser.Eval();
}

const std::vector<std::size_t>& Formula::used() const { return parser_->used; }

bool Formula::may_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto part = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || name.size() > 40 || name == "pi" || !letter(name[0]) ||
      !std::all_of(name.begin(), name.end(), part)) {
    return false;
  }
  return mu::Parser().GetFunDef().count(name) == 0;
}

}  // namespace thermotwin::metrology
