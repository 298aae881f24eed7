// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// First guesses for a sequence of systems A_l d = r_l with matrices that stand, one for each load l: the combination of
// earlier solutions whose A d is nearest to the right-hand side (Fischer 1998), by the normal equations of each load.
// It keeps what an iteration adds to a guess. A full store begins anew from the whole solution.

#include <Eigen/Core>

#include <vector>

#include "core/binary.h"
#include "solver/linear/side_by_side.h"

namespace thermotwin::solver {

class WarmStart {
public:
  /// @param most  solutions that are kept; 0: none, and no guess is made
  explicit WarmStart(Eigen::Index most) : most_(most) {}

  /// Forgets all, since the matrices change.
  void clear() { count_ = 0; }

  /// Subtracts from the right-hand sides r what A times the guess is, and sets d to the guess.
  /// @param d  (size x loads) zero   @param r  (size x loads)   @return whether d may differ from zero
  bool guess(SideBySide& d, SideBySide& r);
  /// Keeps what has been added to the guess. @param d  the solutions   @param r  their residuals
  void remember(const SideBySide& d, const SideBySide& r);

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

private:
  struct Earlier {
    SideBySide z, az;
  };
  /// Inner products of the last solution's A z with all, into its row and column.
  void complete_products();

  Eigen::Index most_;
  Eigen::Index count_ = 0;
  std::vector<Earlier> earlier_;           // the first count_ of them
  std::vector<Eigen::MatrixXd> products_;  // of each load, (most x most): A z_i times A z_j
  Eigen::VectorXd squares_;                // (loads) |r|^2 of the right-hand sides
  SideBySide given_, guessed_, left_;      // right-hand side, if a restart needs it; the guess, and what it leaves
};

}  // namespace thermotwin::solver
