// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes the data of the online core as one block of bytes (model_bytes.h reads it).

#include <string>

#include "compensation/control/control_data.h"

namespace thermotwin::compensation {

std::string control_bytes(const ControlData& data);

}  // namespace thermotwin::compensation
