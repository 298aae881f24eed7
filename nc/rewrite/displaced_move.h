// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A move of the program, and where its points have to be for the predicted offsets of the axes.

#include <string>
#include <vector>

#include "nc/motion/axis_motion.h"
#include "nc/prediction/prediction.h"
#include "nc/rewrite/rewrite_options.h"

namespace thermotwin::nc {

/// @return whether the arc is one or more full circles
bool whole_turns(const Arc& arc);

/// @return the centre nearest to `wanted` that is equally far from both ends, seen along `normal`
Eigen::Vector3d centre_of(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& wanted,
                          const Eigen::Vector3d& normal);

class DisplacedMove {
public:
  /// Keeps references. @param predicted  move of one block of the program  @param place  file:line, for messages
  DisplacedMove(const PredictedMove& predicted, const AxisMotion& motion, const RewriteOptions& options,
                const std::string& place)
      : predicted_(predicted),
        motion_(motion),
        options_(options),
        place_(place),
        bends_(bends()) {}

  const Source& source() const { return *predicted_.timed->element.source; }
  const Move& move() const { return source().move; }

  /// @param u  share of the move that is done; the offsets are those at the time of this share
  /// @return displacement of the programmed point, m. In a rapid move, and at the begin of any move, an axis whose
  ///   offset would take it past the end of its travel stays at that end
  /// @throws InputError  if an offset is too large, or if an axis leaves its travel elsewhere
  Eigen::Vector3d displacement(double u) const;
  bool is_cut() const { return cut_; }  ///< an offset was cut at the end of a travel

  /// Ends of the lines or arcs that follow the displaced move within the tolerance, as shares; the last one is 1.
  /// @param at_start, at_end  displacements
  std::vector<double> pieces(const Eigen::Vector3d& at_start, const Eigen::Vector3d& at_end) const;

  /// @return the programmed point that cancels the error at a moment within the move, m, from the planner's axis
  ///   positions at that moment
  Eigen::Vector3d wanted(const MoveSample& sample) const;

private:
  /// @param cuts  whether an axis stays at the end of its travel where its offset passes it; else InputError
  Eigen::Vector3d displacement(const Nine& nominal, Positions positions, const Eigen::VectorXd& offsets,
                               bool cuts) const;
  /// A share of the move with the displacements of its ends.
  struct Span {
    double u0, u1;
    Eigen::Vector3d d0, d1;
    double share(double part) const { return u0 + part * (u1 - u0); }
  };
  /// The line or arc between displaced ends that the program can write.
  struct Follower;
  Follower follower(const Span& span) const;
  bool nearly_closed() const;
  std::vector<double> bends() const;
  void split(const Span& span, int depth, std::vector<double>& ends) const;

  const PredictedMove& predicted_;
  const AxisMotion& motion_;
  const RewriteOptions& options_;
  const std::string& place_;
  mutable bool cut_ = false;
  std::vector<double> bends_;  ///< shares of the move at which rows end
};

}  // namespace thermotwin::nc
