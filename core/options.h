// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Checks of the fields of options, for their validate().

#include <string>

namespace thermotwin::core {

/// @param option   what it is of and the field's name: "compensator step_s"  @param allowed  as a phrase
/// @throws InputError unless it holds
void require_option(bool holds, const std::string& option, double value, const std::string& allowed);

/// @throws InputError unless low <= value <= high
void require_within(const std::string& option, double value, double low, double high);

}  // namespace thermotwin::core
