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
#include <string>
#include <vector>

#include "nc/motion/axis_motion.h"
#include "nc/prediction/prediction.h"
#include "nc/rewrite/displaced_move.h"
#include "nc/rewrite/executed_line.h"
#include "nc/rewrite/feed_words.h"
#include "nc/rewrite/line_modes.h"
#include "nc/rewrite/piece.h"
#include "nc/rewrite/program_line.h"
#include "nc/rewrite/read_back.h"
#include "nc/rewrite/rewrite_options.h"
#include "nc/rewrite/rewritten_text.h"

namespace thermotwin::nc {

class PathRewriter {
public:
  using Expect = std::function<void(const ExpectedMove&, const std::vector<ExpectedPoint>&)>;

  /// @param lines  of the program  @param name  for messages  @param out  receives the new text in parts
  /// @param expect  receives each line and arc of the new text as it is meant, with points within it
  PathRewriter(ProgramText lines, std::string name, const AxisMotion& motion, const RewriteOptions& options,
               std::function<void(const std::string&)> out, Expect expect);
  PathRewriter(const PathRewriter&) = delete;
  PathRewriter& operator=(const PathRewriter&) = delete;

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
  ProgramLine line_of(const std::string& file, std::size_t number) const;
  void settle(ExecutedLine& entry);
  void flush();
  void emit(ExecutedLine& entry);
  void edit(ExecutedLine& entry, const PredictedMove& predicted);
  void stay(ExecutedLine& entry);
  void machine_move(const ExecutedLine& entry, const Source& source);
  void cycle_move(ExecutedLine& entry, const DisplacedMove& displaced, const PredictedMove& predicted);
  void begin_cycle(ExecutedLine& entry);
  void add_points(Piece& piece, const DisplacedMove& displaced, const PredictedMove& predicted) const;
  void write_piece(ProgramLine& line, const ExecutedLine& entry, const Source& source, const Piece& piece);
  void see_begin(const ExecutedLine& entry, const DisplacedMove& displaced);
  void warn() const;
  void expect(const ExecutedLine& entry, const Source& source, const Piece& piece, const Nine& target) const;

  ProgramText program_;
  std::string name_;
  const AxisMotion& motion_;
  RewriteOptions options_;
  Expect expect_;
  RewrittenText text_;
  FeedWords feed_;
  RewriteSummary summary_;
  mutable std::map<std::string, ProgramText> others_;  ///< files of subprograms
  std::deque<ExecutedLine> entries_;
  Nine at_;       ///< where the rewritten program has the control, m and rad
  Nine nominal_;  ///< where the program has it
  bool placed_ = false;
  bool uncorrected_ = true;  ///< the control is where the program has it, as before the first move
  struct Places {
    std::string first;  ///< file:line
    long count = 0;
  };
  Places ramps_, cuts_;  ///< blocks that begin uncorrected, moves whose offset is cut at the end of a travel
  LineModes modes_;      ///< behind the last line that ran
};

}  // namespace thermotwin::nc
