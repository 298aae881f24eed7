// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A small network, which Naumann et al. (2023) name as an alternative: six hyperbolic tangents and a linear
// part beside them on the main components of the inputs, without memory (feed-forward) or with each
// input also past two lags (a recurrent layer whose feedback is fixed: gamma memory, de Vries and
// Principe 1992). Trained by Levenberg and Marquardt with weight decay, whose strength is chosen on
// held-out thirds of the training rows; the mean of three fixed seeds predicts.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

std::unique_ptr<ChannelModel> make_network(bool memory);

}  // namespace thermotwin::compensation
