// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Identified transfer functions (Mares et al. 2019, 2020): ARX by least squares, ARMAX by repeated
// least squares with the noise's own past, output error by a gradient search on the simulated
// output (what a compensation does: it never sees the displacement). Order (1 to 3), grid step and
// inputs (at most four, taken in one after the other) are those with the smallest simulated error on
// thirds of the training data that the fit did not see. Unstable poles are mirrored and the
// numerators fitted again; output error allows for a machine that does not start settled. Where an ambient temperature
// is known by name, the other temperatures enter as differences to it (Mares et al. 2019, eq. 3).

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

enum class TransferMethod { arx, armax, output_error };
std::unique_ptr<ChannelModel> make_transfer_model(TransferMethod method);

}  // namespace thermotwin::compensation
