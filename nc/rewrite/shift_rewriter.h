// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Puts updates of the work offset into the program, at retracted moves: behind a line whose one rapid move goes up
// along Z alone, outside of loops and subprograms, where X, Y and Z are named in G90 before the next cutting move. An
// axis that is not named would stay at the old zero. An update holds the mean displacement over the time of the cutting
// moves up to the next one, in the unit that holds at its place. It is written where it differs from the last by more
// than the tolerance; all other text stays.

#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "nc/motion/axis_motion.h"
#include "nc/prediction/prediction.h"
#include "nc/rewrite/program_line.h"
#include "nc/rewrite/read_back.h"
#include "nc/rewrite/rewrite_options.h"

namespace thermotwin::nc {

class ShiftRewriter {
public:
  /// @param expect  receives each move of the program, which the new text displaces by largest_update() at most
  ShiftRewriter(ProgramText lines, std::string name, const AxisMotion& motion, const RewriteOptions& options,
                std::function<void(const ExpectedMove&)> expect);

  /// @param frame  before the line runs
  void block(const MoveState& state, const std::string& file, const Frame& frame);
  void move(const Move& move);
  void predicted(const PredictedMove& move);
  /// Writes the text with its updates. @param out  receives it in parts
  void finish(const std::function<void(const std::string&)>& out);
  const RewriteSummary& summary() const { return summary_; }
  /// (3) um, largest deviation of a cutting move's displacement from the update in use
  double largest_left_um() const { return largest_left_; }
  /// Numbers of the work offsets that are updated
  const std::set<int>& updated() const { return updated_; }
  double largest_update() const { return largest_update_; }  ///< m, of an axis

private:
  /// Moves between two places of an update.
  struct Section {
    std::size_t behind = 0;  ///< line that it follows
    double unit = 1e-3;      ///< m, behind that line
    Frame frame;             ///< of its first cutting move
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
    double seconds = 0;  ///< of its cutting moves
    bool cuts = false;   ///< one has come
  };
  Eigen::Vector3d displacement(const Source& source, const PredictedMove& predicted, Positions positions,
                               const Eigen::VectorXd& offset_um) const;
  bool is_open(std::size_t line) const;
  void see_words(const std::string& file);

  ProgramText lines_;
  std::string name_;
  const AxisMotion& motion_;
  RewriteOptions options_;
  RewriteSummary summary_;
  std::vector<bool> closed_;  ///< lines within a loop, a branch or a subprogram
  std::vector<Section> sections_;
  std::deque<int> section_of_;       ///< of the moves that wait, in their order
  bool moved_ = false;               ///< a move has come
  std::size_t line_ = 0, last_ = 0;  ///< present line; last one
  std::size_t main_line_ = 0;        ///< last line of the main program that ran
  bool absolute_ = true;             ///< G90
  std::set<char> named_;             ///< X, Y, Z in G90 since the last place of an update
  std::set<int> updated_;
  double unit_ = 1e-3;  ///< m, before the present line
  int moves_in_line_ = 0;
  bool retracts_ = false, main_ = true;
  double largest_left_ = 0, largest_update_ = 0;
  std::function<void(const ExpectedMove&)> expect_;
};

}  // namespace thermotwin::nc
