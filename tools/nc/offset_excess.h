// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Words for offsets beyond the limits of a control, and their refusal in a corrected program.

#include <nlohmann/json_fwd.hpp>

#include <string>

#include "nc/report/beyond_limits.h"
#include "tools/nc/nc.h"

namespace thermotwin::tools {

/// Lines for the summary, each begins with a new line; empty if all offsets are within the limits.
std::string beyond_text(const nc::BeyondLimits& beyond);
/// Adds the keys offset_limits, moves_beyond_largest_offset and moves_beyond_offset_rate.
void to_json(const nc::BeyondLimits& beyond, nlohmann::json& json);
/// @param place  file:line  @throws InputError
[[noreturn]] void refuse_excess(const nc::BeyondLimits::Excess& excess, const nc::BeyondLimits& beyond,
                                const std::string& place, const NcOptions& options);

}  // namespace thermotwin::tools
