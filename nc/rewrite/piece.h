// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A share of a move that the corrected program has as a line or arc of its own.

#include <Eigen/Core>

#include <vector>

#include "nc/program/program.h"
#include "nc/rewrite/read_back.h"

namespace thermotwin::nc {

/// A line or arc that is written for a share of a move.
struct Piece {
  double begin = 0, end = 1;
  Nine target;                                       ///< m and rad
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< m, of an arc
  std::vector<ExpectedPoint> inside;
  bool is_whole() const { return begin == 0.0 && end == 1.0; }
};

}  // namespace thermotwin::nc
