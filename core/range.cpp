// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/range.h"

#include <fmt/format.h>

#include "core/error.h"

namespace thermotwin::core {

std::string phrase(const Range& range) {
  const bool bounded_below = range.low > any_number.low;
  const bool bounded_above = range.high < any_number.high;
  if (bounded_below && bounded_above) return fmt::format("a number from {:.9g} to {:.9g}", range.low, range.high);
  if (range.low == positive.low && !bounded_above) return "a number above 0";
  if (bounded_below) return fmt::format("a number of at least {:.9g}", range.low);
  if (bounded_above) return fmt::format("a number of at most {:.9g}", range.high);
  return "a finite number";
}

void require_option(bool holds, const std::string& field, double value, const std::string& allowed) {
  if (!holds) throw InputError(field, fmt::format("{}", value), allowed);
}

void require_within(const std::string& field, double value, const Range& range) {
  require_option(range.holds(value), field, value, phrase(range));
}

}  // namespace thermotwin::core
