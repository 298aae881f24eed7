// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A reduced system as files: E.mtx, A.mtx, B.mtx, C.mtx, D.mtx and A_film_NAME.mtx where the full system had them, in
// Matrix Market's array format, and system.rom.h5 (HDF5). docs/reference/result_files.md documents both. All appear
// together or not at all.

#include <filesystem>

#include "reduction/systems/system_reduction.h"

namespace thermotwin::reduction {

inline constexpr char system_file_name[] = "system.rom.h5";

/// Refuses the folder of the full matrices, and one where nothing may be written.
/// @throws InputError
void check_system_folder(const std::filesystem::path& folder, const LinearSystem& system);

/// Of a system whose inputs and outputs have names; kept as /system/input_names and output_names, one a line.
struct SystemNames {
  std::vector<std::string> inputs, outputs;
  std::string method;  ///< attribute of the file, in place of the reduction's
};

/// @throws InputError (disk full, no permission); earlier files are then as they were
void write_system(const std::filesystem::path& folder, const LinearSystem& system, const SystemReduction& reduction,
                  const SystemNames* names = nullptr);

/// The model of system.rom.h5. @param films  receives the names of its films
/// @throws InputError: no HDF5 file, not a reduced system, another version, sizes that disagree
ReducedLinearSystem read_system(const std::filesystem::path& path, std::vector<std::string>* films = nullptr);

}  // namespace thermotwin::reduction
