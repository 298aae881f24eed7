// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes the program anew with the predicted offsets in its coordinates. A point is displaced by the offsets of its
// pose and time; under tool centre point control by what they displace the tool's point on the workpiece. A number
// changes where the displacement rounds to another one; all other text stays. A block is split where the displacement
// along it bends by more than the tolerance: into lines, or into arcs about a centre of their own. Loops, subprograms,
// parameters and drilling cycles are written out. Moves of G28, G30 and G53 stay as they are. A feed that counts along
// other axes than in the program (words of linear axes in a move of rotary axes) is written so that the duration stays.

#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nc/motion/axis_motion.h"
#include "nc/prediction/prediction.h"
#include "nc/rewrite/displaced_move.h"
#include "nc/rewrite/line_modes.h"
#include "nc/rewrite/program_line.h"
#include "nc/rewrite/read_back.h"
#include "nc/rewrite/rewrite_options.h"

namespace thermotwin::nc {

class PathRewriter {
public:
  using Expect = std::function<void(const ExpectedMove&, const std::vector<ExpectedPoint>&)>;

  /// @param lines  of the program  @param name  for messages  @param out  receives the new text in parts
  /// @param expect  receives each line and arc of the new text as it is meant, with points within it
  PathRewriter(ProgramText lines, std::string name, const AxisMotion& motion, const RewriteOptions& options,
               std::function<void(const std::string&)> out, Expect expect);

  /// In the interpreter's order.
  /// @param frame  before the line runs
  void block(const MoveState& state, const std::string& file, const Frame& frame);
  void move();                 ///< of the last block
  void dwell(double seconds);  ///< of the last block
  void skipped();
  /// In the same order, later.
  void predicted(const PredictedMove& move);
  /// The end of the program. @return whether the text differs; if not, the original text holds
  bool finish();
  const RewriteSummary& summary() const { return summary_; }

private:
  /// A line of the program in the order of execution.
  struct Entry {
    ProgramLine line;
    std::string place;
    std::size_t number = 0;
    int expected = 0, done = 0;                  ///< moves
    std::vector<std::pair<int, double>> dwells;  ///< moves before each, s
    LineModes modes;
    bool skipped = false, settled = false;
    Frame frame;               ///< behind it
    std::string before, text;  ///< lines that come instead of it, and the line itself
    std::string feed;          ///< word F of a cycle that waits for its first line
    bool edited = false;
  };

  /// A line or arc that is written for a share of a move.
  struct Piece {
    double begin = 0, end = 1;
    Nine target;                                       ///< m and rad
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< m, of an arc
    std::vector<ExpectedPoint> inside;
    bool is_whole() const { return begin == 0.0 && end == 1.0; }
  };

  ProgramLine line_of(const std::string& file, std::size_t number) const;
  void settle(Entry& entry);
  void flush();
  void count(const std::string& text);
  void emit_flat(const Entry& entry);
  void emit(Entry& entry);
  void edit(Entry& entry, const PredictedMove& predicted);
  void stay(Entry& entry);
  void machine_move(const Entry& entry, const Source& source);
  void cycle_move(Entry& entry, const DisplacedMove& displaced, const PredictedMove& predicted);
  void begin_cycle(Entry& entry);
  void add_points(Piece& piece, const DisplacedMove& displaced, const PredictedMove& predicted) const;
  void write_piece(ProgramLine& line, const Entry& entry, const Source& source, const Piece& piece);
  void write_feed(ProgramLine& line, const Entry& entry, const Source& source, const Piece& piece, const Nine& reached);
  std::optional<std::string> feed_word(const Source& source, const Piece& piece, const Nine& reached,
                                       bool inverse) const;
  void see_begin(const Entry& entry, const DisplacedMove& displaced);
  void warn() const;
  void write_arc(ProgramLine& line, const Entry& entry, const Source& source, const Piece& piece, const Nine& reached,
                 bool changed) const;
  static void write_turns(ProgramLine& line, const Move& move, const Piece& piece);
  void expect(const Entry& entry, const Source& source, const Piece& piece, const Nine& target) const;
  static void write_out_feed(ProgramLine& line, const Entry& entry, const Source& source);

  ProgramText lines_;
  std::string name_;
  const AxisMotion& motion_;
  RewriteOptions options_;
  std::function<void(const std::string&)> out_;
  Expect expect_;
  RewriteSummary summary_;
  bool flat_ = true;                                   ///< every line runs once, in order
  bool began_ = false, code_ = false;                  ///< a line, a line with words has left, where it is not flat
  bool ended_ = false;                                 ///< a line with M2 or M30 has left, where it is not flat
  mutable std::map<std::string, ProgramText> others_;  ///< files of subprograms
  std::deque<Entry> entries_;
  std::size_t written_ = 0;  ///< lines of the program that have left, where it is flat
  Nine at_;                  ///< where the rewritten program has the control, m and rad
  Nine nominal_;             ///< where the program has it
  bool placed_ = false;
  bool uncorrected_ = true;  ///< the control is where the program has it, as before the first move
  bool other_feed_ = false;  ///< the last F of the new text is another one than the program's
  bool per_minute_ = false;  ///< the new text has left G93 for the present line
  struct Places {
    std::string first;  ///< file:line
    long count = 0;
  };
  Places ramps_, cuts_;  ///< blocks that begin uncorrected, moves whose offset is cut at the end of a travel
  LineModes modes_;      ///< behind the last line that ran
};

}  // namespace thermotwin::nc
