// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a control does with a program beyond LinuxCNC's interpreter, as a control profile (TOML) says: words of its own,
// dynamics of the axes, tools and work offsets. docs/reference/control.md documents the keys.

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "nc/control/letters.h"

namespace thermotwin::nc {

struct WordRule {
  enum class Action { skip, replace, tcp_on, tcp_off, refuse };
  Action action = Action::skip;
  char letter = 'G';
  double number = 0;
  std::string by, with, says;
  std::string name;  ///< of a statement with a name, of Siemens programs; empty: the letter and number hold
};

struct Tool {
  int number = 0;
  std::string name;                        ///< as T="NAME" calls it; empty: none
  Nine offset = Nine::Zero();              ///< m and rad
  double diameter = 0;                     ///< m
  double front_angle = 0, back_angle = 0;  ///< deg, of lathe tools
  int orientation = 0;
};

struct WorkOffset {
  int number = 1;
  Nine offset = Nine::Zero();  ///< m and rad
  double rotation = 0;         ///< rad about Z
};

/// Limits of one axis of the machine, SI.
struct AxisLimits {
  double speed, acceleration;
};

/// The language of a program.
enum class Dialect { rs274, fanuc, siemens };

struct ControlProfile {
  std::string name;
  Dialect dialect = Dialect::rs274;
  double arc_radius_tolerance = 0, blend_tolerance = 0;         ///< m
  double block_cycle = 0;                                       ///< s, shortest time of a path element
  bool overlaps_corners = false;                                ///< see planner.h
  bool block_delete = true;                                     ///< lines that begin with / are left out
  int look_ahead = 0;                                           ///< path elements
  double tool_change = 0, program_stop = 0, spindle_start = 0;  ///< s
  double moves = 0, lines_without_move = 0, seconds = 0;
  bool moves_stated = false;  ///< else they are limited by the lines of the program as well
  std::vector<WordRule> words;
  std::vector<Tool> tools;
  std::vector<WorkOffset> work_offsets;
  std::vector<AxisLimits> axes;  ///< (axes of the machine)

  /// Takes the tools of a table instead; those of the profile with the same number keep their names.
  void use_table(std::vector<Tool> table);

  /// @param name  "linuxcnc", "fanuc", "siemens" or a file  @throws InputError (file, line, key)
  static ControlProfile load(const std::string& name, const mesh::Machine& machine);
  static ControlProfile parse(const std::string& text, const std::string& source, const mesh::Machine& machine);
};

/// The text of a profile that comes with the program; empty: there is none of this name.
std::string built_in_profile(const std::string& name);

/// A tool table of LinuxCNC (T1 P1 Z12.5 D6 ;comment), lengths in mm. @throws InputError (file, line)
std::vector<Tool> read_tool_table(const std::filesystem::path& path);

/// Letter of a machine axis in a program, 0 to 8; -1: it has none.
int letter_of(const mesh::Axis& axis);

}  // namespace thermotwin::nc
