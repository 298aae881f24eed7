// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.h"

namespace thermotwin::core {

InputError::InputError(const std::string& place, const std::string& value, const std::string& allowed)
    : Error(place + ": " + value + "; allowed: " + allowed) {}

}  // namespace thermotwin::core
