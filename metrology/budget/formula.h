// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A formula of named quantities, such as "V / I * cos(phi)": + - * / ^, comparisons, ( ), ?:, pi, and the functions of
// muParser (sin, cos, tan, asin, acos, atan, atan2, sinh, exp, ln, log10, sqrt, abs, min, max, ...). One value comes
// out; nothing can be assigned. One object belongs to one thread.

#include <memory>
#include <string>
#include <vector>

namespace thermotwin::metrology {

class Formula {
public:
  /// @param names  of the quantities it may use, in the order of the values @param place  for messages
  /// @throws InputError: an unknown name (with the nearest), an assignment, several values, a syntax error
  Formula(const std::string& text, const std::vector<std::string>& names, const std::string& place);
  ~Formula();
  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;

  /// @param values  (names) @return may be not finite
  double operator()(const double* values) const;

  /// Positions in names of the quantities that the formula has.
  const std::vector<std::size_t>& used() const;

  /// @return whether a quantity may have this name: a letter, then letters, digits and _; no function or constant
  static bool may_name(const std::string& name);

private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace thermotwin::metrology
