// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// blocks.csv of `nc`: the predicted error at the end of each move.

#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "nc/prediction/prediction.h"

namespace thermotwin::tools {

/// @param axes  with offsets
std::string blocks_header(const mesh::Machine& machine, const std::vector<std::string>& axes);
/// @param number  of the move, from 1
std::string block_text(const mesh::Machine& machine, const nc::PredictedMove& move, long number);

}  // namespace thermotwin::tools
