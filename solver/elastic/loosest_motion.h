// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The rigid motion that the springs of a pose hold least, with the bodies taken as rigid:
//   K v = lambda v,  K = sum over springs of k r r',  r_b = sum of weights times R_b' w
// R_b being a body's translations and its rotations about its centre times its length, so that v has one unit (m) and
// lambda is a stiffness in N/m. What is held by a lever of a few millimetres only shows as a lambda far below the
// others: displacements are then decided by the shape of single elements.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "solver/elastic/spring.h"

namespace thermotwin::solver {

struct BodyResponse;

struct LoosestMotion {
  double ratio = 1.0;       ///< least lambda over the median of all; 0: nothing holds it
  std::vector<int> bodies;  ///< that take part, into Machine::bodies
  std::vector<int> joints;  ///< with stiffness on these bodies, into Machine::joints
  std::string motion;       ///< "to turn about x through (0, 240, -60) mm", "to move along y"
  bool turns = false;       ///< a rotation, no translation
};

/// @param elastic    bodies that are elastic, rising
/// @param responses  per body of the machine
LoosestMotion loosest_motion(const std::vector<int>& elastic, const std::vector<BodyResponse>& responses,
                             const std::vector<Spring>& springs);

}  // namespace thermotwin::solver
