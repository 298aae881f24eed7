// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/parameter_sizes.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "solver/operation/layout.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double relative_change(double now, double before) { return before != 0.0 ? now / before - 1.0 : 0.0; }

}  // namespace

bool PartChanges::differs_in_rows(const PartChanges& other) const {
  return bodies != other.bodies || scales != other.scales || screws != other.screws || stiffness != other.stiffness;
}

PartChanges part_changes(const mesh::Machine& base, const mesh::Machine& machine) {
  PartChanges changes;
  const auto size = [](const auto& items) { return std::ssize(items); };
  changes.capacity.setZero(size(base.bodies) + size(base.volumes));
  changes.bodies.setZero(size(base.bodies));
  for (std::size_t b = 0; b < base.bodies.size(); ++b) {
    const mesh::Material &before = base.material(base.bodies[b].material),
                         &now = machine.material(machine.bodies[b].material);
    changes.capacity[b] =
        relative_change(now.density * now.specific_heat.value, before.density * before.specific_heat.value);
    changes.bodies[b] = relative_change(now.expansion.value, before.expansion.value);
  }
  for (std::size_t v = 0; v < base.volumes.size(); ++v) {
    changes.capacity[size(base.bodies) + v] =
        relative_change(machine.volumes[v].capacity.value, base.volumes[v].capacity.value);
  }
  changes.scales.setZero(size(base.scales));
  for (std::size_t i = 0; i < base.scales.size(); ++i)
    changes.scales[i] = relative_change(machine.scales[i].expansion.value, base.scales[i].expansion.value);
  changes.screws.setZero(size(base.screws));
  for (std::size_t i = 0; i < base.screws.size(); ++i)
    changes.screws[i] = relative_change(machine.screws[i].expansion.value, base.screws[i].expansion.value);
  changes.stiffness.setZero(size(base.joints));
  for (std::size_t i = 0; i < base.joints.size(); ++i) {
    if (base.joints[i].stiffness_normal.value > 0.0)
      changes.stiffness[i] = std::log(machine.joints[i].stiffness_normal.value / base.joints[i].stiffness_normal.value);
  }
  return changes;
}

VectorXd stiffness_amounts(const reduction::Parts& parts, const PartChanges& changes) {
  VectorXd amounts(changes.stiffness.size());
  for (Index j = 0; j < amounts.size(); ++j)
    amounts[j] = changes.stiffness[j] == 0.0 ? 0.0 : parts.stiffness_amount(j, changes.stiffness[j]);
  return amounts;
}

AddedSources added_sources(const reduction::ReducedModel& model, const mesh::Machine& machine) {
  AddedSources added{model.system.layout, {}};
  const int own = std::ssize(model.machine.sources);
  if (std::ssize(machine.sources) <= own) return added;
  const auto& patches = model.patches.items;
  added.inputs.resize(model.system.order(), machine.sources.size() - own);
  for (int i = own; i < std::ssize(machine.sources); ++i) {
    const mesh::SourceSpec& source = machine.sources[i];
    const auto patch = std::find_if(patches.begin(), patches.end(), [&](const reduction::Patch& p) {
      return source.places.size() == 1 && p.surface.id == source.places.front().surface;
    });
    if (patch == patches.end()) {
      throw core::InputError("source " + source.id, "a source that the reduced model does not have",
                             "a source whose only place is a surface patch of the model, or a new run of thermotwin "
                             "reduce");
    }
    added.layout.inputs.push_back({.kind = solver::InputKind::source, .item = i});
    added.inputs.col(i - own) = model.patches.inputs.col(patch - patches.begin());
  }
  return added;
}

reduction::ReducedModel model_of_changed(const reduction::ReducedModel& model, const mesh::Machine& machine) {
  reduction::ReducedModel changed = model;
  changed.machine = machine;
  if (AddedSources added = added_sources(model, machine); added.inputs.cols() > 0) {
    changed.system.layout = std::move(added.layout);
    changed.system.inputs.conservativeResize(Eigen::NoChange, model.system.inputs.cols() + added.inputs.cols());
    changed.system.inputs.rightCols(added.inputs.cols()) = added.inputs;
  }
  if (!model.parts) return changed;
  const PartChanges changes = part_changes(model.machine, machine);
  for (Index i = 0; i < std::ssize(changed.parts->capacity); ++i) {
    Eigen::MatrixXd& part = changed.parts->capacity[i];
    changed.system.capacity += changes.capacity[i] * part;
    part *= 1.0 + changes.capacity[i];
  }
  const auto add = [&](std::vector<reduction::ReducedOutputs>& parts, const VectorXd& amounts, const VectorXd& growth) {
    for (Index i = 0; i < amounts.size(); ++i) {
      reduction::ReducedOutputs& part = parts[i];
      if (amounts[i] == 0.0 || part.tool.empty()) continue;
      for (const auto rows : {&reduction::ReducedOutputs::tool, &reduction::ReducedOutputs::table_axis,
                              &reduction::ReducedOutputs::table_own}) {
        for (std::size_t pose = 0; pose < (part.*rows).size(); ++pose) {
          (changed.outputs.*rows)[pose] += amounts[i] * (part.*rows)[pose];
          (part.*rows)[pose] *= growth[i];
        }
      }
    }
  };
  const auto ratio = [](const VectorXd& change) { return VectorXd(change.array() + 1.0); };
  add(changed.parts->bodies, changes.bodies, ratio(changes.bodies));
  add(changed.parts->scales, changes.scales, ratio(changes.scales));
  add(changed.parts->screws, changes.screws, ratio(changes.screws));
  const VectorXd grown = (changes.stiffness.array() * model.parts->stiffness_exponent.array()).exp();
  add(changed.parts->stiffness, stiffness_amounts(*model.parts, changes), grown);
  return changed;
}

}  // namespace thermotwin::diagnosis
