// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The summary of `nc`: as a JSON object and as text for the terminal.

#include <nlohmann/json_fwd.hpp>

#include <string>

#include "tools/nc/outcome.h"

namespace thermotwin::tools {

nlohmann::json summary(const Outcome& found);
std::string summary_text(const Outcome& found);

}  // namespace thermotwin::tools
