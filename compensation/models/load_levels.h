// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Load levels of a measurement, between which the factors of a one-point model are interpolated (Okenka et al.).

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/dataset.h"

namespace thermotwin::compensation {

struct Levels {
  std::string input;           ///< empty: none
  std::vector<double> values;  ///< rising, of the input's unit
};

/// Levels of the speed or power that is above 0 in most training rows: values that a tenth of these rows or more have.
Levels load_levels(const Dataset& data, const std::vector<bool>& training);

/// (levels, at least one) weights, linear between levels, constant beyond them.
Eigen::VectorXd level_shares(const std::vector<double>& levels, double at);

/// (rows) last value above 0 of the load input; the lowest level before it.
Eigen::VectorXd levels_of_rows(const Dataset& data, const std::string& input, const std::vector<double>& levels);

}  // namespace thermotwin::compensation
