// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What holds a linear axis in its position: a scale, a screw with the position from the motor's encoder, or a joint
// with stiffness that is no guide of the axis. Without one a body slides, and no displacement can be computed.

#include <string>
#include <vector>

#include "mesh/machine/machine.h"

namespace thermotwin::solver {

/// A linear axis that nothing holds, and the first elastic body that it moves.
struct UnheldAxis {
  std::string axis, body;
};
std::vector<UnheldAxis> unheld_axes(const mesh::Machine& machine);

/// What machine.toml lacks for one, as a phrase.
inline constexpr const char* what_holds_an_axis =
    "a [[scale]] of this axis, a [[screw]] with feedback = \"screw\", or a joint with stiffness that is no guide";

}  // namespace thermotwin::solver
