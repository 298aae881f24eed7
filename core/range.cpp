// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace thermotwin::core {
namespace {

/// A bound without the slack that rounding needs: -60.0000002 is written -60, 8000.000008 is 8000, and -1e-7 is 0.
std::string bound(double value) {
  constexpr double slack_share = 2e-9;
  const double round = std::round(1e3 * value) / 1e3;
  const bool slack =
      std::abs(value - round) < std::max(5e-7, slack_share * std::abs(value)) && (round != 0.0 || value < 0.0);
  return fmt::format("{:.9g}", slack ? round + 0.0 : value);
}

}  // namespace

std::string phrase(const Range& range) {
  const bool bounded_below = range.low > any_number.low;
  const bool bounded_above = range.high < any_number.high;
  if (bounded_below && bounded_above) return "a number from " + bound(range.low) + " to " + bound(range.high);
  if (range.low == positive.low && !bounded_above) return "a number above 0";
  if (bounded_below) return "a number of at least " + bound(range.low);
  if (bounded_above) return "a number of at most " + bound(range.high);
  return "a finite number";
}

void require_option(bool holds, const std::string& field, double value, const std::string& allowed) {
  if (!holds) throw InputError(field, fmt::format("{}", value), allowed);
}

void require_within(const std::string& field, double value, const Range& range) {
  require_option(range.holds(value), field, value, phrase(range));
}

}  // namespace thermotwin::core
