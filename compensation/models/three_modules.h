// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The composite correlative model of Naumann et al. (2023). Its three modules are fitted one after the other, each on
// the programs that the source assigns to it (Fig. 1, sections 2.2 and 3.1).
//   1  Programs with the machine off, in the steady state. The displacement is a piecewise linear curve over the
//      baseline, which is the mean of the first ambient sensor over up to three days. Modules 2 and 3 use temperatures
//      above the baseline.
//   2  Programs with the machine on, and no speed, power or other state. The residual of module 1 follows two ambient
//      sensors in three modes (stable, cold, warm), blended by (8) and (9). Stable: a bilinear characteristic diagram
//      of both. Cold and warm: powers of the first sensor and a multiple of the second, as (10). Both sensors pass a
//      one-sided Gaussian filter, and two first-order elements of each add delays. From each other sensor the module
//      subtracts the response a T + b (1 / (1 + |2 T|) - 1) to T, one of the ambient sensors, by (1) to (7).
//   3  The other programs. The residual of modules 1 and 2 follows the other sensors after this subtraction. Features
//      of a sensor are its value, the value past first-order elements, and the excess above half of its largest
//      training value (a characteristic diagram in one variable).
// Ridges, filter and time constants minimise the error on whole programs left out. The ambient sensors are the two
// temperatures whose range depends least on the program, among the programs of module 3. In training the baseline is
// the reading at the start of a program, as in the source; in prediction it is the running mean.
// Limits: needs programs of all three kinds; one displacement at one pose, or one side of it.

#include <memory>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

/// Deviations from the source for an ablation study, one at a time.
struct ThreeModulesOptions {
  bool together = false;    ///< one fit of modules 2 and 3, on the programs of both
  bool delays = true;       ///< false: no filter, no first-order element
  bool bed_sensors = true;  ///< false: the air in place of the ambient sensors
  bool baseline = true;     ///< false: no module 1; baseline: mean start of module 2's training programs
};

std::unique_ptr<ChannelModel> make_three_modules(ThreeModulesOptions options);

}  // namespace thermotwin::compensation
