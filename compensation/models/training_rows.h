// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a fit may see of a measurement: the inputs that its kind of model uses, and the rows up to the last one of
// training.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/dataset.h"
#include "compensation/models/catalogue.h"

namespace thermotwin::compensation {

/// Columns that a model of this choice may use: known in half of the training rows and moving there.
std::vector<Eigen::Index> usable_inputs(const Dataset& data, const std::vector<bool>& training, InputChoice choice);

/// Rows up to the last one that a fit may use; targets of the others are unknown to it. After a stretch comes a row of
/// rest: over the pause nothing is held, what is slow comes to rest, and what the next stretch begins with begins
/// there. How long it was does not matter: twice the longest stretch is enough for all that one can show.
/// @param used  columns of the inputs  @param model  its name, for messages
TrainingData training_data(const Dataset& data, const std::vector<bool>& training, Eigen::Index target,
                           const std::vector<Eigen::Index>& used, const std::string& model);

}  // namespace thermotwin::compensation
