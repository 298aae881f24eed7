// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The online core with one model as an FMU for co-simulation (FMI 2.0 or 3.0): description, a Linux library, the model
// in resources/model.bin, and the sources of the library. The library needs libc and libm alone.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "compensation/control/control_data.h"

namespace thermotwin::compensation {

/// @return the library of an FMU, embedded at build time
std::string_view fmu2_library();
std::string_view fmu3_library();

/// @return modelDescription.xml
std::string fmu2_description(const ControlData& data, const std::vector<std::string>& sources);
std::string fmu3_description(const ControlData& data);

struct ArchiveFile {
  std::string name, content;
};
/// @return a zip archive of files as they are, without compression; the same bytes for the same files
std::string stored_zip(const std::vector<ArchiveFile>& files);

/// Writes the FMU to a file.  @param version  of FMI, 2 or 3  @throws InputError if the file cannot be written
void write_fmu(const std::filesystem::path& path, const ControlData& data, int version);

}  // namespace thermotwin::compensation
