// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Grey-box thermal model: every input heats parts of the machine with time constants tau_m, and the
// displacement is their sum, y = c + sum_i sum_m g_im x_im, tau_m dx_im/dt + x_im = u_i. A spectrum
// of five time constants from five minutes to a third of the measurement (a slower one
// cannot be told from a ramp) stands for what one sensor cannot know of the structure behind it.
// Many gains from little data need to be held: they are normal with zero mean, and the residual of
// the fit is not white but drifts (an exponentially correlated part with a time constant of its
// own), and the machine does not start in equilibrium (a decaying part for each time constant). The
// sizes of these contributions are where the training data are most probable (evidence, with broad priors),
// so nothing is tuned on data that the fit does not see. Ordinary least squares takes neighbouring
// residuals for independent and trusts gains that a slow drift invented.
// Only c and g predict: the decays and the drift belong to the training record.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

std::unique_ptr<ChannelModel> make_grey_box();

}  // namespace thermotwin::compensation
