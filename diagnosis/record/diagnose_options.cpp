// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/diagnose_options.h"

#include <string>
#include <utility>

#include "core/range.h"

namespace thermotwin::diagnosis {

void DiagnoseOptions::validate() const {
  core::require_option(heldout_share >= 0.05 && heldout_share <= 0.9, "diagnose heldout_share", heldout_share,
                       "0.05 to 0.9");
  for (const auto& [name, percent] : {std::pair{"displacement_error_percent", displacement_error_percent},
                                      {"temperature_error_percent", temperature_error_percent}})
    if (percent)
      core::require_option(*percent > 0 && *percent <= 50, std::string("diagnose ") + name, *percent,
                           "above 0, at most 50");
  core::require_option(interval_s > 0, "diagnose interval_s", interval_s, "a positive number of seconds");
}

}  // namespace thermotwin::diagnosis
