// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a LinuxCNC configuration (INI file and its HAL files) already has: axes, joints, thread, and the signals that
// pins are linked to. HAL refuses to link a pin twice, so new pins join the signal that is there.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace thermotwin::compensation {

struct HalAxis {
  char letter = 'X';
  int joint = 0;
  double fastest = 0;        ///< MAX_VELOCITY of [AXIS_L], machine units/s; 0: not stated
  bool has_offsets = false;  ///< OFFSET_AV_RATIO is above 0
};

struct HalConfig {
  std::filesystem::path ini;
  std::vector<HalAxis> axes;
  double mm_per_unit = 1;               ///< 1 or 25.4
  std::string kinematics;               ///< name of the module, such as trivkins
  std::string thread = "servo-thread";  ///< that runs motion-controller
  std::map<std::string, std::string> signal_of_pin;
  std::map<std::string, std::string> place_of_pin;  ///< FILE:LINE of that link
  std::vector<std::string> components;              ///< names that loadrt and loadusr -Wn give
  std::vector<std::string> unread;                  ///< HAL files in Tcl, and those that are not found, with the reason

  /// @return the axis of the letter, or nullptr
  const HalAxis* axis(char letter) const;
};

/// @param library  folder of HAL files that INI files name as LIB:NAME
/// @throws InputError with file and line: unreadable INI file, no [KINS]KINEMATICS, coordinates or units that are none
HalConfig read_hal_config(const std::filesystem::path& ini,
                          const std::filesystem::path& library = "/usr/share/linuxcnc/hallib");

}  // namespace thermotwin::compensation
