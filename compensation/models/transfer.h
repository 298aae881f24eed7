// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Models of identified transfer functions (Mares et al. 2019, 2020). Order (1 to 3), grid step and inputs (at most
// four, taken in one after the other) are those with the smallest simulated error on thirds of the training data that
// the fit did not see. Where an ambient temperature is known by name, the other temperatures enter as differences to it
// (Mares et al. 2019, eq. 3).

#include <memory>

#include "compensation/models/channel_model.h"
#include "compensation/models/transfer_identification.h"

namespace thermotwin::compensation {

std::unique_ptr<ChannelModel> make_transfer_model(TransferMethod method);

}  // namespace thermotwin::compensation
