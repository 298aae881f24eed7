// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A reduced model of a smaller order for a control: the leading blocks, since bases are nested. What the smaller order
// costs is estimated by the largest RMS over the workspace between the TCP errors of both, after eight hours at each
// operating point that the basis is made from (as offset_limits.h), and is added to the stated error of the model.

#include <Eigen/Core>

#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// @return the model as it is for order 0 or its own order
/// @throws InputError for an order below 1 or above that of the model
reduction::ReducedModel model_of_order(reduction::ReducedModel model, Eigen::Index order);

}  // namespace thermotwin::compensation
