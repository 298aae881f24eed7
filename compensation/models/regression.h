// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Regressions without memory or with one lag: displacement = intercept + sum gain_i T_i, where T_i
// may have passed a first-order lag. The baseline that dynamic models are held against.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

/// Ordinary least squares, all temperatures, intercept.
std::unique_ptr<ChannelModel> make_static_regression();
/// The same with a ridge whose strength is chosen on held-out blocks of the training rows.
std::unique_ptr<ChannelModel> make_ridge_regression();
/// Adds inputs one after another while the error on held-out blocks falls by more than 2 %. If no single input does
/// so, it falls back on the ridge regression and reports that in caution().
std::unique_ptr<ChannelModel> make_selected_regression();
/// sum of gain_i / (1 + tau s) applied to each temperature, one tau for all.
std::unique_ptr<ChannelModel> make_first_order();

}  // namespace thermotwin::compensation
