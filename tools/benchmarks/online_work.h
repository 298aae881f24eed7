// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Work beside a control: steps of a reduced model with all outputs, rows as a control sends them, and the answers to
// them.

#include "tools/benchmarks/work_options.h"

namespace thermotwin::bench {

/// Steps of a control: the state moves on and all outputs of the grid are read, with no film changing, with
/// three, with all; and the plain way, which sums and factorises in each step.
void online(const Options& options);
/// A CSV of what a control sends once a second: speeds that change every minutes, axes that move.
void rows(const Options& options);
void control(const Options& options);

}  // namespace thermotwin::bench
