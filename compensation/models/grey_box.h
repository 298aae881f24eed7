// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Grey-box thermal model of one displacement y: each input u_i drives first-order lags x_im with time constants tau_m,
//   y = c + sum_i sum_m g_im x_im,   tau_m dx_im/dt + x_im = u_i.
// Five time constants approximate the unknown structure between an input and the displacement. The slowest is a third
// of the longest stretch without a gap, because a slower lag is not distinguishable from a ramp. The fastest is five
// minutes, or a tenth of the slowest if that is shorter.
// Few data do not determine so many gains. The gains therefore have a normal prior with zero mean. The residual of the
// fit has white noise, an exponentially correlated drift with a time constant of its own, and a decay for each tau_m,
// because the machine does not start in equilibrium. The standard deviations of these parts maximise the evidence of
// the training data under broad priors, so nothing is tuned on held-out data. Ordinary least squares would assume
// independent residuals, and would explain a slow drift by gains.
// Only c and g predict; decays and drift belong to the training record.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

std::unique_ptr<ChannelModel> make_grey_box();

}  // namespace thermotwin::compensation
