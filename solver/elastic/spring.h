// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A spring or constraint between elastic bodies: the gap
//   sum of weights times unit functionals of bodies  (= force / stiffness + own expansion),
// unit functionals being those whose K^+ is solved for beforehand.

#include <Eigen/Core>

#include <utility>
#include <vector>

#include "solver/elastic/functionals.h"

namespace thermotwin::solver {

/// One unit functional of one body in a sum.
struct UnitTerm {
  int body;  ///< index into Machine::bodies
  int unit;  ///< index into UnitFunctionals of the body
  double weight;
};
using Combination = std::vector<UnitTerm>;

/// Unit functionals per body, collected before the factors are made.
class UnitFunctionals {
public:
  explicit UnitFunctionals(std::size_t bodies) : of_body_(bodies) {}
  int add(int body, Functional functional);
  const std::vector<Functional>& of(int body) const { return of_body_[body]; }

private:
  std::vector<std::vector<Functional>> of_body_;
};

struct Spring {
  Combination gap;                             ///< slave minus master; scale: head minus place of the tape's end
  double flexibility = 0;                      ///< m/N; 0: constraint
  int expansion_body = -1;                     ///< scale, screw: body whose temperature stretches it
  int screw = -1;                              ///< the pull of a stretched screw: index into Machine::screws
  int joint = -1;                              ///< whose stiffness it has: index into Machine::joints
  int expands_scale = -1, expands_screw = -1;  ///< what expands: index into Machine::scales, screws
  std::vector<std::pair<Eigen::Index, double>> expansion;  ///< (node of that body, m/K)
};

}  // namespace thermotwin::solver
