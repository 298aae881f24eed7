// SPDX-License-Identifier: GPL-3.0-or-later
// Order of terms and inputs, and the weights of joint grids.

#include "solver/operation/layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solver/operation/grid_occupancy.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::solver {

int Layout::observed_index(ObservedKind kind, int item) const {
  for (int i = 0; i < std::ssize(observed); ++i)
    if (observed[i].kind == kind && observed[i].item == item) return i;
  return -1;
}

int reading_index(const mesh::Machine& machine, const Layout& layout, ObservedKind kind, int item) {
  const int observed = layout.observed_index(kind, item), sensors = std::ssize(machine.sensors);
  return observed < 0 ? -1 : sensors + observed;
}

Layout make_layout(const mesh::Machine& machine, std::vector<JointGrid> grids) {
  Layout layout;
  layout.grids = std::move(grids);
  const auto next_term = [&]() -> int { return std::ssize(layout.terms); };
  for (int i = 0; i < std::ssize(machine.films); ++i) {
    const mesh::FilmSpec& film = machine.films[i];
    // One to a volume has no ambient of its own: the volume is part of the state.
    if (const int ambient = machine.ambient_index(film.ambient); ambient >= 0) {
      layout.inputs.push_back({.kind = InputKind::film_ambient, .term = next_term(), .item = i});
      if (machine.ambients[ambient].has_gradient)
        layout.inputs.push_back({.kind = InputKind::film_gradient, .term = next_term(), .item = i});
    }
    layout.terms.push_back({TermKind::film, i, 0});
    if (film.of_temperature || (film.emissivity.value > 0.0 && film.exact_radiation))
      layout.observed.push_back({ObservedKind::film, i});
  }
  for (int i = 0; i < std::ssize(machine.joints); ++i) {
    const bool grounded = machine.joints[i].master.empty();
    if (!machine.joints[i].law.by_temperature.at.empty()) layout.observed.push_back({ObservedKind::joint, i});
    const int nodes = layout.grids[i].positions.size();
    for (int node = 0; node < nodes; ++node) {
      if (grounded)
        layout.inputs.push_back({.kind = InputKind::contact_ambient, .term = next_term(), .item = i, .node = node});
      layout.terms.push_back({TermKind::contact, i, node});
    }
  }
  for (int i = 0; i < std::ssize(machine.coolants); ++i) {
    for (int s = 0; s < std::ssize(machine.coolants[i].segments); ++s)
      layout.terms.push_back({TermKind::coolant_wall, i, s});
    layout.inputs.push_back({.kind = InputKind::coolant_inlet, .term = next_term(), .item = i});
    layout.terms.push_back({TermKind::coolant_flow, i, 0});
  }
  for (int i = 0; i < std::ssize(machine.volumes); ++i) {
    const mesh::VolumeSpec& volume = machine.volumes[i];
    for (int e = 0; e < std::ssize(volume.exchanges); ++e) {
      if (machine.volume_index(volume.exchanges[e].with) < 0)
        layout.inputs.push_back({.kind = InputKind::volume_ambient, .term = next_term(), .item = i, .place = e});
      layout.terms.push_back({TermKind::volume_exchange, i, e});
    }
    layout.inputs.push_back({.kind = InputKind::volume_given, .term = next_term(), .item = i});
    layout.terms.push_back({TermKind::volume_given, i, 0});
  }
  for (int i = 0; i < std::ssize(machine.coolants); ++i) {
    if (const mesh::CoolantSpec& coolant = machine.coolants[i];
        coolant.controls_return || coolant.control == mesh::ChillerControl::pi)
      layout.observed.push_back({ObservedKind::coolant_return, i});
  }
  for (int i = 0; i < std::ssize(machine.volumes); ++i) {
    const std::string& id = machine.volumes[i].id;
    const bool guides = std::any_of(machine.coolants.begin(), machine.coolants.end(),
                                    [&](const mesh::CoolantSpec& coolant) { return coolant.guide_warmed_by == id; });
    const bool drives = std::any_of(machine.films.begin(), machine.films.end(), [&](const mesh::FilmSpec& film) {
      return film.of_temperature && film.ambient == id;
    });
    if (guides || drives) layout.observed.push_back({ObservedKind::volume, i});
  }
  for (int i = 0; i < std::ssize(machine.sources); ++i) {
    const mesh::SourceSpec& source = machine.sources[i];
    for (int k = 0; k < std::ssize(source.places); ++k) {
      const std::string& joint = source.places[k].joint;
      const int nodes = joint.empty() ? 1 : std::ssize(layout.grids[machine.joint_index(joint)].positions);
      for (int node = 0; node < nodes; ++node)
        layout.inputs.push_back({.kind = InputKind::source, .item = i, .place = k, .node = node});
    }
  }
  return layout;
}

}  // namespace thermotwin::solver
