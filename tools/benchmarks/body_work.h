// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Work on one body: its files for other programs, heat, elasticity by a factor and by multigrid, and how fast the
// machine reads memory.

#include "tools/benchmarks/work_options.h"

namespace thermotwin::bench {

void write_files(const Options& options);
void heat(const Options& options);
/// How fast the machine reads memory: what bounds solves with a factor that no cache holds.
void memory(const Options& options);
void elastic(const Options& options);
/// As elastic, eight columns of it, by multigrid; loads as the elastic model has them: balanced.
void iterative(const Options& options);

}  // namespace thermotwin::bench
