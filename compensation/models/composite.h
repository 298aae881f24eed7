// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Composite correlative model after Naumann et al. (2023). Module 1: the baseline ambient temperature, the
// mean of an ambient sensor over up to three days before now. Module 2: the ambient's deviation from
// it, as it is and past one-sided Gaussian filters of one and three hours, in three modes (stable,
// cold, warm) blended by (8) and (9). Module 3: the other temperatures above the ambient, as they
// are, past a first-order element, and bent at the middle of their range (a characteristic diagram
// in one variable). Gains by ridge, its strength and the time constant on held-out blocks. The ambient
// sensor is the one that is called so; without a name, the mean of all temperatures, which then
// holds module 3 to differences within the structure. Limits: one displacement at one pose; the
// source separates the modules by simulated training data, here they are fitted together.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

std::unique_ptr<ChannelModel> make_composite();

}  // namespace thermotwin::compensation
