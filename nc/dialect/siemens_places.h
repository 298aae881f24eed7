// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where the axes are in a Siemens program, as far as it tells, and the frames that shift them. Coordinates of a block
// become words of LinuxCNC's language, all in one sense. DC, ACP and ACN count from where a rotary axis is.

#include <array>
#include <optional>
#include <string>

#include "nc/control/control_profile.h"
#include "nc/dialect/siemens_value.h"

namespace thermotwin::nc {

using SiemensCoordinates = std::array<std::optional<SiemensValue>, 9>;

class SiemensPlaces {
public:
  /// @param control  work offsets; must outlive this  @param start  of the axes before the program, m and rad
  SiemensPlaces(const ControlProfile& control, const Nine& start);

  void set_absolute(bool absolute) { absolute_ = absolute; }  ///< G90, G91
  void use_work_offset(int number);
  void change_unit(double factor);  ///< of lengths, from the old unit to the new one
  void forget();                    ///< the places of the program: where the axes are is no longer told
  void end_shift() { shift_.fill(0.0); }
  void add_shift(int axis, double by) { shift_[axis] += by; }
  double shift(int axis) const { return shift_[axis]; }

  /// Adds the words of a block's coordinates. @param machine  in machine coordinates  @param tool_length  one is in use
  /// @throws InputError  (place) for coordinates that cannot be written
  void write(SiemensCoordinates axes, bool machine, bool tool_length, const std::string& place, std::string& text);

private:
  double shortest(int axis, const SiemensValue& value, const std::string& place) const;
  double frame_of(int axis) const;
  void turn_to(int axis, const SiemensValue& value, bool machine);

  const ControlProfile& control_;
  std::array<std::optional<double>, 9> at_;  ///< programmed places, program units and deg
  std::array<double, 9> shift_{};            ///< of TRANS and ATRANS, program units and deg
  std::array<double, 9> turned_{};           ///< deg, of the rotary axes in the machine
  int work_ = 1;                             ///< number of the work offset in use
  bool absolute_ = true, written_absolute_ = true;
};

}  // namespace thermotwin::nc
