// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/diagnose_options.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"

namespace thermotwin::diagnosis {

void require_option(bool holds, const std::string& option, double value, const std::string& allowed) {
  if (!holds) throw core::InputError(option, fmt::format("{}", value), allowed);
}

void DiagnoseOptions::validate() const {
  require_option(heldout_share >= 0.05 && heldout_share <= 0.9, "diagnose heldout_share", heldout_share, "0.05 to 0.9");
  for (const auto& [name, percent] : {std::pair{"displacement_error_percent", displacement_error_percent},
                                      {"temperature_error_percent", temperature_error_percent}})
    require_option(percent > 0 && percent <= 50, std::string("diagnose ") + name, percent, "above 0, at most 50");
  require_option(interval_s > 0, "diagnose interval_s", interval_s, "a positive number of seconds");
}

}  // namespace thermotwin::diagnosis
