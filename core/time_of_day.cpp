// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/time_of_day.h"

#include <algorithm>

namespace thermotwin::core {

std::optional<double> hours_of_day(std::string_view text) {
  const auto digit = [&](std::size_t at) { return text[at] - '0'; };
  constexpr std::size_t places[] = {0, 1, 3, 4};
  if (text.size() != 5 || text[2] != ':' || !std::all_of(std::begin(places), std::end(places), [&](std::size_t at) {
        return digit(at) >= 0 && digit(at) <= 9;
      }))
    return std::nullopt;
  const int hours = 10 * digit(0) + digit(1), minutes = 10 * digit(3) + digit(4);
  if (hours > 23 || minutes > 59) return std::nullopt;
  return hours + minutes / 60.0;
}

}  // namespace thermotwin::core
