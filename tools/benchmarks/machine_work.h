// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Work on the whole machine: load programs side by side, output rows of poses, steps of the full and the reduced model.

#include "tools/benchmarks/work_options.h"

namespace thermotwin::bench {

/// Nine programs of one time grid, as a block or each by itself.
void loads(const Options& options);
void poses(const Options& options);
/// The same steps of a load on the full and on the reduced model, in turns of ten steps.
void steps(const Options& options);

}  // namespace thermotwin::bench
