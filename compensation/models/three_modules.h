// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The composite correlative model of Naumann et al. (2023) with its three modules fitted one after the other, each on
// the programs that its source has for it (Fig. 1, sections 2.2 and 3.1).
//   1  programs with the machine off, in the steady state: a piecewise linear curve over the baseline, the mean of an
//      ambient sensor over up to three days. All temperatures are then taken less the baseline.
//   2  programs with the machine on and no speed, power or state beside: what module 1 leaves, from two ambient sensors
//      in three modes (stable, cold, warm) blended by (8) and (9). Stable: a bilinear diagram of both. Cold and warm:
//      powers of the first and a share of the second, as (10). Inputs pass a one-sided Gaussian filter; two first-order
//      elements of each add the delays. It also offsets the other sensors by (1) to (7), a T + b (1 / (1 + |2 T|) - 1).
//   3  the other programs: what modules 1 and 2 leave, from the offset sensors as they are, past first-order elements,
//      and above half of their training range (a characteristic diagram in one variable).
// Ridges, filter and time constants are those with the least error on whole programs left out. The ambient sensors are
// the two temperatures whose range depends least on the program that runs, among the programs of module 3. Training
// takes the baseline at the start of a program, as the source does; at work it is the running mean.
// Limits: needs programs of all three kinds; one displacement at one pose, or one side of it.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

/// Departures from the source, one cause at a time, for an ablation.
struct ThreeModulesOptions {
  bool together = false;    ///< one fit of the features of all modules on all programs
  bool delays = true;       ///< false: no filter, no first-order element
  bool bed_sensors = true;  ///< false: the air in place of the ambient sensors
  bool baseline = true;     ///< false: no module 1, module 2 from the reference of its training
};

std::unique_ptr<ChannelModel> make_three_modules(ThreeModulesOptions options);

}  // namespace thermotwin::compensation
