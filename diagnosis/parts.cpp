// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/parts.h"

#include <cmath>

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double relative_change(double now, double before) { return before != 0.0 ? now / before - 1.0 : 0.0; }

}  // namespace

bool PartChanges::any_rows() const {
  for (const VectorXd* values : {&bodies, &scales, &screws, &stiffness})
    if ((values->array() != 0.0).any()) return true;
  return false;
}

PartChanges part_changes(const mesh::Machine& base, const mesh::Machine& machine) {
  PartChanges changes;
  const auto size = [](const auto& items) { return static_cast<Index>(items.size()); };
  changes.capacity.setZero(size(base.bodies));
  changes.bodies.setZero(size(base.bodies));
  for (std::size_t b = 0; b < base.bodies.size(); ++b) {
    const mesh::Material &before = base.material(base.bodies[b].material), &now = machine.material(machine.bodies[b].material);
    changes.capacity[static_cast<Index>(b)] = relative_change(now.density * now.specific_heat.value, before.density * before.specific_heat.value);
    changes.bodies[static_cast<Index>(b)] = relative_change(now.expansion.value, before.expansion.value);
  }
  changes.scales.setZero(size(base.scales));
  for (std::size_t i = 0; i < base.scales.size(); ++i)
    changes.scales[static_cast<Index>(i)] = relative_change(machine.scales[i].expansion.value, base.scales[i].expansion.value);
  changes.screws.setZero(size(base.screws));
  for (std::size_t i = 0; i < base.screws.size(); ++i)
    changes.screws[static_cast<Index>(i)] = relative_change(machine.screws[i].expansion.value, base.screws[i].expansion.value);
  changes.stiffness.setZero(size(base.joints));
  for (std::size_t i = 0; i < base.joints.size(); ++i)
    if (base.joints[i].stiffness_normal.value > 0.0)
      changes.stiffness[static_cast<Index>(i)] = std::log(machine.joints[i].stiffness_normal.value / base.joints[i].stiffness_normal.value);
  return changes;
}

}  // namespace thermotwin::diagnosis
