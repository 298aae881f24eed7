// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Module 1 of the composite correlative model (compensation/models/three_modules.h): the displacement of a machine in
// its steady state over the baseline.

#include <Eigen/Core>

#include <algorithm>
#include <vector>

#include "compensation/measurement/dataset.h"
#include "compensation/models/module_features.h"
#include "compensation/models/module_programs.h"

namespace thermotwin::compensation {

/// Piecewise linear curve over the baseline; straight on beyond its ends.
struct BaselineCurve {
  Eigen::VectorXd at, value;
  double operator()(double x) const {
    if (at.size() == 0) return 0.0;
    if (at.size() == 1) return value[0];
    const Eigen::Index above =
        std::clamp<Eigen::Index>(std::upper_bound(at.begin(), at.end(), x) - at.begin(), 1, at.size() - 1);
    const double share = (x - at[above - 1]) / (at[above] - at[above - 1]);
    return value[above - 1] + share * (value[above] - value[above - 1]);
  }
};

/// Knots at the steady states of the programs with the machine off.
/// @throws InputError  for fewer than two steady temperatures
BaselineCurve fit_baseline(const TrainingData& data, const std::vector<ModuleProgram>& stretches,
                           const ModuleLayout& layout);

}  // namespace thermotwin::compensation
