// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// bound.rom.h5: a BoundModel as HDF5, documented in docs/reference/result_files.md. It belongs to a model.rom.h5 of the
// same machine and mesh, which holds the list of terms and inputs.

#include <filesystem>

#include "reduction/bound/model.h"

namespace thermotwin::reduction {

inline constexpr int bound_file_version = 3;

/// Whole or not at all. @throws InputError (disk full, no permission)
void write_bound(const std::filesystem::path& path, const BoundModel& bound);

/// @param model  whose errors it bounds
/// @throws InputError: no HDF5 file, no such file, another version, machine or mesh, sizes that disagree
BoundModel read_bound(const std::filesystem::path& path, const ReducedModel& model);

}  // namespace thermotwin::reduction
