// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/options.h"

#include <fmt/format.h>

#include "core/error.h"

namespace thermotwin::core {

void require_option(bool holds, const std::string& option, double value, const std::string& allowed) {
  if (!holds) throw InputError(option, fmt::format("{}", value), allowed);
}

void require_within(const std::string& option, double value, double low, double high) {
  require_option(value >= low && value <= high, option, value, fmt::format("{} to {}", low, high));
}

}  // namespace thermotwin::core
