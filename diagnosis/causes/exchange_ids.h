// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Names of the exchanges of a volume, by which hypotheses speak of them.

#include <string>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @return (exchanges) "<volume>.<with>"; of several with the same partner "<volume>.<with>.<state>", and from the
///   second of the same state on with its number behind it, " 2"
std::vector<std::string> exchange_ids(const mesh::VolumeSpec& volume);

}  // namespace thermotwin::diagnosis
