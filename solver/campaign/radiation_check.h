// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Estimates the error of linearised radiation. A film with radiation = "linear" has h = 4 eps sigma T_ref^3; its heat
// flux is compared with that of the fourth powers, at the mean temperatures of its surfaces and its surroundings.

#include <string>
#include <vector>

#include "solver/campaign/simulation.h"

namespace thermotwin::solver {

class RadiationCheck {
public:
  RadiationCheck(const mesh::Machine& machine, const ThermalSystem& system);

  void add(const OperatingModel& model, const std::string& load, const OutputState& output);
  /// @return a warning about the film with the largest error, if above 1 % of its radiation; else an empty text
  std::string warning() const;

private:
  struct Film {
    int film;
    Eigen::SparseVector<double> mean;  // weights of the nodes
    // The largest relative error of the heat flux so far, and the temperatures at that time.
    double off = 0, surface_C = 0, surroundings_C = 0;
    std::string load;
  };
  const mesh::Machine& machine_;
  std::vector<Film> films_;
};

}  // namespace thermotwin::solver
