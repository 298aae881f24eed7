// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// An NC program as moves of the control's axes: records of the interpreter with units, rotation, work offsets and tool
// offsets worked in,
//   axes = R(rotation) (programmed unit + G92) + work offset + tool offset.
// A move is constant memory; a program of any length passes through.

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nc/program/interpreter.h"

namespace thermotwin::nc {

enum class MoveKind { traverse, feed, arc, probe, tap };

/// What holds during a move.
struct MoveState {
  std::uint32_t line = 0;
  std::uint16_t file = 0;   ///< index into Program::files
  std::uint16_t depth = 0;  ///< of subprograms
  int tool = 0;             ///< in the spindle; 0: none
  int operation = 0;        ///< counts tool changes and program stops
  int part = 0;             ///< run of the program, from 0
  int logged = 0;           ///< events of a control's log that have come, see LoggedTimes
  double spindle_rpm = 0;   ///< negative: counterclockwise
  bool flood = false, mist = false;
  bool tcp = false;  ///< tool centre point control
  double dwelt = 0;  ///< s, of all dwells so far
};

/// Offsets that lie between the program's coordinates and the axes.
struct Frame {
  double unit = 1e-3;   ///< m
  double rotation = 0;  ///< rad
  int work_number = 1;
  double feed = 0;             ///< feed rate as programmed
  double angular_feed = 0;     ///< the same of rotary axes alone, which no unit of length changes
  bool degrees_count = false;  ///< a feed of lines and angles counts along both, a degree as a unit of length (Fanuc)
  bool feed_per_turn = false;  ///< G95
  Nine work = Nine::Zero(), g92 = Nine::Zero(), tool = Nine::Zero();  ///< m and rad

  /// @param programmed  program units and deg
  Nine to_axes(const Nine& programmed) const;
  Nine to_program(const Nine& axes) const;
  /// Length of a straight move as the feed rate counts it: of X Y Z, else of U V W (m), else of A B C (rad); with
  /// degrees_count of lengths and angles together (m).
  double feed_length(const Nine& change) const;
};

struct Arc {
  Eigen::Vector3d centre, first, second;    ///< m; unit vectors of the start radius and a quarter turn on, axes X Y Z
  double start_radius = 0, end_radius = 0;  ///< m
  double angle = 0;                         ///< rad, above 0, in the sense from first to second
};

struct Move {
  MoveKind kind = MoveKind::traverse;
  Nine from, to;                                          ///< axes, m and rad, with the tool offset
  Arc arc;                                                ///< of kind arc
  Eigen::Vector3d tool_offset = Eigen::Vector3d::Zero();  ///< m
  double length = 0;     ///< along the programmed path: m, or rad where only angles move
  double speed = 0;      ///< m/s or rad/s of that path; 0: rapid
  int path_mode = 3;     ///< 1 exact stop, 2 exact path, 3 continuous
  double tolerance = 0;  ///< m, of continuous path; 0: none stated
  MoveState state;

  /// Whether it is straight and moves neither X Y Z nor U V W.
  bool has_only_angles() const;
};

/// Whether neither X Y Z nor U V W change.
bool has_only_angles(const Nine& change);

/// Length of a straight move: of X Y Z, else of U V W (m), else of A B C (rad).
double straight_length(const Nine& change);

/// Time without motion.
struct Pause {
  enum class Kind { dwell, tool_change, stop, spindle } kind = Kind::dwell;
  double seconds = 0;
  MoveState state;
};

/// A line of the program is about to run.
struct Block {
  MoveState state;
  const std::string& file;
};

struct ProgramSink {
  std::function<void(const Move&, const Frame&)> move;
  std::function<void(const Pause&)> pause;
  std::function<void(const Block&, const Frame&)> block;  ///< may be empty, as the next one
  std::function<void()> skipped;                          ///< the last block was read and not executed
};

struct ProgramSummary {
  std::vector<std::string> files;
  long deletable = 0;       ///< lines of the program that begin with /
  bool open_end = false;    ///< it ended without M2, M30 or %
  long probes = 0;          ///< probing moves, which run to their end
  std::string first_probe;  ///< file and line of the first
  long moves = 0, blocks = 0, tool_changes = 0, stops = 0;
  long traverses = 0, feeds = 0, arcs = 0;
  MoveState end;  ///< behind the last line, as the frame
  Frame frame;
};

/// @throws InputError: see interpret(); arcs whose radii differ; a feed without a feed rate
ProgramSummary read_program(const InterpreterOptions& options, const ControlProfile& control, const ProgramSink& sink);

}  // namespace thermotwin::nc
