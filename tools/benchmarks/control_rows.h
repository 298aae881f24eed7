// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time of single rows of the online core, and of the C++ compensator beside it.

#include <filesystem>

namespace thermotwin::bench {

/// Rows at 10 Hz of machine time, fed as fast as they are taken: speeds that change every ten minutes, axes that move.
/// Prints quantiles of the processor time and of the wall time of a row, sizes, and how long a start takes.
void control_rows(const std::filesystem::path& model_file, long rows);

}  // namespace thermotwin::bench
