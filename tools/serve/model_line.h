// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The first line of the model process of `serve`, before the lines of JSON for its rows: what the front has to know
// before there is a row, or why there will be none.
//   {"axes": ["x", "y", "z"], "limits": {"largest_um": ..., "rate_um_s": ...}, "state_s": 3600.0}   null: cold start
//   {"refused": "other_model", "what": "serve.state: a state of another model ..."}
// refused: the faults of StateFault, or "input" for a model, header or row that cannot be used. The process then ends.

#include <string>

#include "compensation/control/online_twin.h"
#include "core/error.h"

namespace thermotwin::tools {

std::string announcement(const compensation::OnlineTwin& twin);
std::string refusal(const core::InputError& error);

}  // namespace thermotwin::tools
