// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time integration of a load program: [time] of the load program, else of its case.

#include <string>

#include "core/config.h"

namespace thermotwin::solver {

enum class TimeScheme {
  fixed,           ///< SDIRK2 at the program's time steps; loads of one time grid run as one block
  backward_euler,  ///< first order at the same steps
  adaptive         ///< TR-BDF2 with error control, each load with steps of its own
};

struct TimeOptions {
  TimeScheme scheme = TimeScheme::fixed;
  double tolerance_K = 0.01;    ///< adaptive: largest estimated error of a step at any node
  double shortest_step = 0.01;  ///< s; a step of this length is kept whatever its error
  double longest_step = 21600;  ///< s
  void validate() const;        ///< @throws InputError
};

/// Keys of a [time] table. @throws InputError
TimeOptions read_time(const core::Node& node);

/// "fixed", ...
std::string word(TimeScheme scheme);

}  // namespace thermotwin::solver
