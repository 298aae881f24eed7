// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How far radiation that a film has linearised at the reference temperature, h = 4 eps sigma T_ref^3,
// is from the fourth powers, between the mean temperature of its surfaces and its surroundings.

#include <string>
#include <vector>

#include "solver/campaign/simulation.h"

namespace thermotwin::solver {

class RadiationCheck {
public:
  RadiationCheck(const mesh::Machine& machine, const ThermalSystem& system);

  void add(const OperatingModel& model, const std::string& load, const OutputState& output);
  /// The film that errs most, if by more than 1 % of its radiation; else nothing.
  std::string warning() const;

private:
  struct Film {
    int film;
    Eigen::SparseVector<double> mean;  // weights of the nodes
    double off = 0, surface_C = 0, surroundings_C = 0;
    std::string load;
  };
  const mesh::Machine& machine_;
  std::vector<Film> films_;
};

}  // namespace thermotwin::solver
