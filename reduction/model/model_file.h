// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads and writes model.rom.h5, the reduced model as HDF5, which h5py and MATLAB read as well.
// docs/reference/result_files.md documents its content. The file keeps the text of machine.toml, so a model needs no
// other file.

#include <filesystem>

#include "reduction/model/reduced_model.h"

namespace thermotwin::reduction {

inline constexpr int model_file_version = 3;

/// Writes the file whole or not at all. @throws InputError (disk full, no permission)
void write_model(const std::filesystem::path& path, const ReducedModel& model);

/// @throws InputError if the file is no HDF5 file, no thermotwin model, of another version or inconsistent
ReducedModel read_model(const std::filesystem::path& path);

}  // namespace thermotwin::reduction
