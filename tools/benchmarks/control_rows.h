// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time of single rows of the online core, and of the C++ compensator beside it.

#include <filesystem>

namespace thermotwin::bench {

/// Rows at 10 Hz of machine time, fed as fast as they are taken: speeds that change every ten minutes, axes that move.
/// Prints quantiles of the processor time and of the wall time of a row, sizes, and how long a start takes.
void control_rows(const std::filesystem::path& model_file, long rows);

/// Rows at their own pace, 10 a second: quantiles of the processor time and of the wall time of a row.
void live_rows(const std::filesystem::path& model_file, long rows);

/// Rows as fast as they are taken, but the caches are lost between two of them, as they are in real time: quantiles of
/// the lower processor time of two runs of each row, and what the slowest rows had to do.
void cold_rows(const std::filesystem::path& model_file, long rows);

/// Prints the largest difference between the core, whose terms are in low rank, and the class with dense terms along a
/// load. @param folder  of a campaign's load: inputs.csv and sensors.csv
void compared_rows(const std::filesystem::path& model_file, const std::filesystem::path& folder);

}  // namespace thermotwin::bench
