// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A piece of motion of the machine's axes over its own parameter u from 0 to 1:
//   q(u) = base + slope u + r(u) (first cos(angle u) + second sin(angle u)),  r(u) = r0 + (r1 - r0) u.
// A line has angle 0 and r 0. The path length is proportional to u.

#include <Eigen/Core>

#include <memory>

#include "nc/program/program.h"

namespace thermotwin::nc {

/// Positions or speeds of the machine's axes in their order, m and rad.
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 9, 1>;

/// A whole move of the program with the offsets that were in use.
struct Source {
  Move move;
  Frame frame;
};

struct Element {
  Positions base, slope, first, second;
  double r0 = 0, r1 = 0, angle = 0;
  double length = 0;  ///< of the program's path, m or rad
  double speed = 0;   ///< along it; 0: rapid
  bool rapid = false, exact_stop = false;
  bool angular = false;  ///< length and speed are angles: the programmed move is one of rotary axes alone
  int path_mode = 3;
  double tolerance = 0;  ///< m
  double pause = 0;      ///< s; above 0: a pause at base
  bool last = false;     ///< of its move
  MoveState state;
  std::shared_ptr<const Source> source;  ///< of the last element of a move, where it is asked for

  static Element line(const Positions& from, const Positions& to);

  Positions at(double u) const;
  Positions end() const { return at(1.0); }
  Positions derivative(double u) const;  ///< dq/du
  /// (axes) largest |dq/du|
  Positions fastest() const;

  /// Adds the distance that each axis covers from u0 to u1, and widens low and high by what it reaches.
  void sweep(double u0, double u1, Positions& travel, Positions& low, Positions& high) const;
};

}  // namespace thermotwin::nc
