// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The rigid motion with the least stiffness at a pose. The bodies are taken as rigid:
//   K v = lambda v,  K = sum over springs of k r r',  r_b = sum of weights times R_b' w.
// w is a unit functional. R_b holds a body's translations, and its rotations about its centre divided by its length.
// All entries of v are therefore in m, and lambda is in N/m. A body that is held only by a lever of a few millimetres
// has a lambda far below the others. Its displacement then depends on the shape of single elements.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "solver/elastic/spring.h"

namespace thermotwin::solver {

struct BodyResponse;

struct LoosestMotion {
  double ratio = 1.0;       ///< least lambda over the median of all; 0: nothing holds it
  std::vector<int> bodies;  ///< bodies that move, indices into Machine::bodies
  std::vector<int> joints;  ///< joints with stiffness on them, indices into Machine::joints
  std::string motion;       ///< "to turn about x through (0, 240, -60) mm", "to move along y"
  bool turns = false;       ///< a rotation, no translation
};

/// @param elastic    bodies that are elastic, rising
/// @param responses  per body of the machine
LoosestMotion loosest_motion(const std::vector<int>& elastic, const std::vector<BodyResponse>& responses,
                             const std::vector<Spring>& springs);

}  // namespace thermotwin::solver
