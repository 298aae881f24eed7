// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// model.rom.h5: the reduced model as HDF5, documented in reduction/README.md, readable with h5py and
// MATLAB. It keeps machine.toml's text, so the model needs no other file.

#include <filesystem>

#include "reduction/model/reduced_model.h"

namespace thermotwin::reduction {

inline constexpr int model_file_version = 3;

/// Whole or not at all. @throws InputError (disk full, no permission)
void write_model(const std::filesystem::path& path, const ReducedModel& model);

/// @throws InputError: no HDF5 file, not a thermotwin model, another version, sizes that disagree
ReducedModel read_model(const std::filesystem::path& path);

}  // namespace thermotwin::reduction
