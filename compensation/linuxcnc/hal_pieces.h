// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes what a LinuxCNC configuration needs to be compensated by a reduced model: C source of the model, its process,
// the pins in HAL, a real-time guard, and the pieces of HAL and INI that join them to this configuration.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/control/control_data.h"
#include "compensation/control/control_source.h"
#include "compensation/linuxcnc/hal_config.h"

namespace thermotwin::compensation {

/// @return processes, guard and build script (embedded at build time)
const std::vector<EmbeddedFile>& linuxcnc_files();

struct HalPieces {
  std::string hal;                    ///< thermotwin.hal
  std::string ini;                    ///< lines for the INI file
  std::vector<std::string> linked;    ///< channels that a pin of LinuxCNC gives
  std::vector<std::string> unlinked;  ///< channels that nothing gives yet
};

/// @param folder  absolute path of the written folder
/// @throws InputError  kinematics that are not trivkins; a linear axis of the model that the configuration does not
///   have; an external offset of such an axis, or a name, that is in use already (with file and line)
HalPieces hal_pieces(const HalConfig& config, const ControlData& model, const std::filesystem::path& folder);

/// Writes all files. @return their names, from the folder
std::vector<std::filesystem::path> write_linuxcnc(const std::filesystem::path& folder, const ControlData& data,
                                                  const tt_model& model, const HalPieces& pieces);

}  // namespace thermotwin::compensation
