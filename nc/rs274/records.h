// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// The stream of records from the process of LinuxCNC's interpreter (helper) to the program that started it (host). A
// record is a Head of eight bytes, then values of eight bytes each, or text. Head::mask has a bit for each value:
// values that did not change since the last record of the same kind are left out. Settings and offsets are always
// complete.

#include <cstdint>

namespace thermotwin::nc::rs274 {

enum class Kind : std::uint8_t {
  block = 1,  ///< a line of the last `file` begins; index: depth of subprograms
  file,       ///< text: the file that the following lines are in
  traverse,   ///< x y z a b c u v w, program coordinates in the length unit of the last setting
  feed,       ///< the same, at the feed rate
  probe,      ///< the same, until the probe touches
  tap,        ///< x y z, synchronous with the spindle (rigid tapping), and back
  arc,        ///< ends and centre in the plane of the last setting, see ArcValue
  offset,     ///< index: OffsetKind; nine values
  setting,    ///< index: Setting; one or two values
  marker,     ///< text: a comment that the control profile has put in place of a word
  error,      ///< index: Stop; text
  end         ///< the program has ended; index: depth of subprograms
};

enum ArcValue : std::uint8_t {
  first_end,
  second_end,
  first_centre,
  second_centre,
  turns,     ///< > 0 counterclockwise
  axis_end,  ///< along the axis of the helix
  arc_a,
  arc_b,
  arc_c,
  arc_u,
  arc_v,
  arc_w,
  arc_values
};

enum class OffsetKind : std::uint8_t { work, g92, tool };

enum class Setting : std::uint8_t {
  length_unit,      ///< mm
  plane,            ///< 1 XY, 2 YZ, 3 XZ
  feed_rate,        ///< length units per minute, or per revolution
  feed_mode,        ///< 0: per minute, 1: per revolution
  rotation,         ///< deg about Z
  path_mode,        ///< 1 exact stop, 2 exact path, 3 continuous; tolerance in units
  spindle_speed,    ///< rpm
  spindle_turns,    ///< 1 clockwise, -1 counterclockwise, 0 stands
  surface_speed,    ///< constant surface speed: largest rpm; 0 off
  flood,            ///< 1 on
  mist,             ///< 1 on
  dwell,            ///< s
  tool_selected,    ///< number
  tool_change,      ///< number of the tool that is then in the spindle
  stop,             ///< 0 program stop, 1 optional
  synchronous,      ///< feed per revolution in length units; 0 off
  compensation,     ///< cutter radius: 1 left, 2 right, 0 off
  work_offset_set,  ///< number of the work offset in use, 1 to 9
  skipped,          ///< the line was read and not executed: a branch not taken, the body of a subprogram
  open_end          ///< the file ended without M2, M30 or %
};

/// Reason for the end of the stream before the end of the program.
enum class Stop : std::uint8_t {
  program,      ///< the interpreter refuses the program
  file,         ///< a file could not be read, or lies outside of the program's folder
  moves,        ///< more moves than allowed
  idle_blocks,  ///< more lines without a move than allowed
  time,         ///< more processor time than allowed
  internal
};

struct Head {
  Kind kind;
  std::uint8_t index;
  std::uint16_t mask;  ///< of values; of text: its length in bytes
  std::uint32_t line;  ///< of the file, from 1
};
static_assert(sizeof(Head) == 8);

}  // namespace thermotwin::nc::rs274
