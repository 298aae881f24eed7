// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/finer_pads.h"

#include <algorithm>

namespace thermotwin::mesh {

Machine with_finer_pads(Machine machine, int times) {
  for (JointSpec& joint : machine.joints) {
    joint.divide = joint.divide.unaryExpr([&](int cells) { return cells > 1 ? cells * times : cells; }).eval();
    if (joint.sectors > 1) joint.sectors *= times;
  }
  return machine;
}

bool has_divided_pads(const Machine& machine) {
  return std::any_of(machine.joints.begin(), machine.joints.end(), [](const JointSpec& joint) {
    return joint.stiffness_normal.value > 0.0 && (joint.divide.maxCoeff() > 1 || joint.sectors > 1);
  });
}

}  // namespace thermotwin::mesh
