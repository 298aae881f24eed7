// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Training data of a fit: the inputs that its kind of model uses, and the rows up to the last training row.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/dataset.h"
#include "compensation/models/catalogue.h"

namespace thermotwin::compensation {

/// @return columns of the inputs of this choice that have a value in at least half of the training rows, and more than
///   one value there
std::vector<Eigen::Index> usable_inputs(const Dataset& data, const std::vector<bool>& training, InputChoice choice);

/// Rows up to the last training row; targets of rows that are not for training are NaN. A row of rest is added after
/// each stretch but the last: its speeds and powers are 0, and its other inputs are those of the next stretch's first
/// row. So no input is held over the pause, and slow responses come to rest. A pause is shortened to twice the longest
/// stretch.
/// @param target  column of the targets  @param used  columns of the inputs  @param model  its name, for messages
TrainingData training_data(const Dataset& data, const std::vector<bool>& training, Eigen::Index target,
                           const std::vector<Eigen::Index>& used, const std::string& model);

}  // namespace thermotwin::compensation
