// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The motion of a machine in a test, block by block: rapids, feeds, arcs, turns, dwells, spindle. A block becomes a
// line of the NC program. A stage is a run of blocks and becomes one phase of the load program. The phase has for each
// axis the range of its positions, its mean feed and the share of time in which it moves. Feed times time is then the
// path of the blocks.
// Every position is checked against the travel and every speed against the rapid of its axis.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/machine/kinematics.h"

namespace thermotwin::metrology {

struct NcBlock {
  std::string words;               ///< ISO 6983 without the number
  std::string says;                ///< comment; may be empty
  double start = 0, duration = 0;  ///< s
};

struct AxisUse {
  double low = 0, high = 0;   ///< m or rad, of the positions
  double path = 0;            ///< m or rad
  double moving = 0;          ///< s
  double begin = 0, end = 0;  ///< positions at both ends of the stage
  bool turns = false;         ///< an endless axis turns in whole turns
};

struct Stage {
  std::string name;
  int cycle = 0;  ///< of the measurement; 0: none is measured
  double start = 0, duration = 0;
  double spindle_rpm = 0;
  std::vector<AxisUse> axes;  ///< of the machine
  std::vector<NcBlock> blocks;
};

class Timeline {
public:
  /// @param machine  must outlive it  @param place  of messages, such as "plan rtest"
  Timeline(const mesh::Machine& machine, mesh::Pose start, std::string place);

  void begin_stage(const std::string& name, int cycle = 0);
  /// All axes to their targets at once at rapid. Endless axes go forward by the difference.
  void rapid(const mesh::Pose& target, const std::string& says = "");
  /// The same in a straight line; the feed is that of the axis with the longest time.
  /// @param linear  feed of linear axes, m/s  @param rotary  of rotary ones, rad/s
  void feed(const mesh::Pose& target, double linear, double rotary, const std::string& says = "");
  /// A rotary axis turns at a speed while linear axes follow on a circle. @param way  poses along it, the last is the
  /// end  @param words  of the NC program, without feed  @param speed  rad/s  @param feed_mm_min  along the circle
  void arc(int axis, const std::vector<mesh::Pose>& way, double speed, const std::string& words, double feed_mm_min,
           const std::string& says);
  /// An endless axis turns by whole turns; it ends where it began. @param speed  rad/s
  void turn(int axis, long turns, double speed, const std::string& says = "");
  void dwell(double seconds, const std::string& says = "");
  void spindle(double rpm);  ///< at the start of a stage

  const std::vector<Stage>& stages() const { return stages_; }
  double now() const { return now_; }  ///< s
  const mesh::Pose& pose() const { return pose_; }
  double fastest(int axis) const;  ///< m/s or rad/s; without a rapid 1 m/s or 1 rad/s

private:
  void move(const mesh::Pose& target, double duration, const std::string& words, const std::string& says);
  void require_in_travel(const mesh::Pose& target) const;
  std::string target_words(const mesh::Pose& target) const;

  const mesh::Machine& machine_;
  mesh::Pose pose_;
  std::string place_;
  double now_ = 0, spindle_rpm_ = 0;
  std::vector<Stage> stages_;
};

/// The NC program: numbered blocks of ISO 6983, each with its comment. @param title  ASCII
std::string nc_text(const mesh::Machine& machine, const Timeline& timeline, const std::string& title);

/// The load program of docs/reference/load.md, a phase a stage.
/// @param air_C  temperature of the ambient `air` at both ends and in the middle, linear between @param initial_C  of
///   the machine where no air is stated
std::string load_text(const mesh::Machine& machine, const Timeline& timeline, const std::string& title,
                      const std::optional<std::pair<double, double>>& air_C, double initial_C);

}  // namespace thermotwin::metrology
