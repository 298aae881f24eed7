// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The words and numbers of the page of `nc`: what it says of a run, and the commands that may follow.

#include "nc/report/report.h"
#include "tools/nc/outcome.h"

namespace thermotwin::tools {

/// @param found  with a model
nc::Report report_of(const Outcome& found);

}  // namespace thermotwin::tools
