// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/items.h"

#include <cmath>
#include <utility>

#include "diagnosis/causes/exchange_ids.h"
#include "diagnosis/causes/offered_causes.h"

namespace thermotwin::study {

using diagnosis::Effect;
using diagnosis::Kind;
using diagnosis::Parameter;
using diagnosis::Target;

namespace {

std::vector<Item> materials_and_bodies(const mesh::Machine& machine, Kind kind) {
  std::vector<Item> items;
  const auto stated = [&](const mesh::Material& material) {
    return kind == Kind::expansion_coefficient ? material.expansion.std_percent : material.specific_heat.std_percent;
  };
  for (const mesh::Material& material : machine.materials) {
    bool used = false;
    for (const mesh::BodySpec& body : machine.bodies) used = used || body.material == material.id;
    if (used) items.push_back({material.id, stated(material)});
  }
  // A body is the same value again: `*` means the materials.
  for (const mesh::BodySpec& body : machine.bodies) items.push_back({body.id, 0.0});
  return items;
}

std::vector<Item> sources(const mesh::Machine& machine, Kind kind) {
  const bool scale = kind == Kind::source_power || kind == Kind::process_heat;
  std::vector<Item> items;
  for (const mesh::SourceSpec& source : machine.sources)
    items.push_back({source.id, scale ? source.scale.std_percent : 0.0});
  return items;
}

std::vector<Item> joints(const mesh::Machine& machine, Kind kind) {
  const auto value_of = [&](const mesh::JointSpec& joint) {
    if (kind == Kind::contact_stiffness) return joint.stiffness_normal;
    return kind == Kind::contact_pressure ? joint.law.pressure : joint.conductance;
  };
  std::vector<Item> items;
  for (const mesh::JointSpec& joint : machine.joints) {
    const core::Uncertain value = value_of(joint);
    // Without a stiffness or a law of pressure there is nothing that the kind may change.
    if (kind != Kind::contact_conductance && !(value.value > 0.0)) continue;
    items.push_back({joint.id, value.std_percent});
  }
  return items;
}

std::vector<Item> segments(const mesh::Machine& machine) {
  std::vector<Item> items;
  for (const mesh::CoolantSpec& coolant : machine.coolants)
    for (const mesh::CoolantSegment& segment : coolant.segments)
      items.push_back({coolant.id + "." + segment.id, segment.film_coefficient.std_percent});
  return items;
}

std::vector<Item> exchanges(const mesh::Machine& machine) {
  std::vector<Item> items;
  for (const mesh::VolumeSpec& volume : machine.volumes) {
    const std::vector<std::string> ids = diagnosis::exchange_ids(volume);
    for (std::size_t i = 0; i < ids.size(); ++i) items.push_back({ids[i], volume.exchanges[i].conductance.std_percent});
  }
  return items;
}

/// All items of the kind's table, whether or not it acts on them.
std::vector<Item> items_of_table(const mesh::Machine& machine, Kind kind) {
  std::vector<Item> items;
  switch (diagnosis::row_of(kind).target) {
    case Target::source: return sources(machine, kind);
    case Target::film:
      for (const mesh::FilmSpec& film : machine.films)
        items.push_back({film.id, kind == Kind::film_coefficient ? film.coefficient.std_percent : 0.0});
      break;
    case Target::ambient:
      for (const mesh::AmbientSpec& ambient : machine.ambients) {
        if (kind != Kind::ambient_gradient) {
          items.push_back({ambient.id, 0.0});
        } else if (ambient.has_gradient) {
          items.push_back({ambient.id, ambient.gradient.std_percent, std::abs(ambient.gradient.value)});
        }
      }
      break;
    case Target::joint: return joints(machine, kind);
    case Target::coolant:
      for (const mesh::CoolantSpec& coolant : machine.coolants)
        items.push_back({coolant.id, kind == Kind::coolant_flow ? coolant.flow.std_percent : 0.0});
      break;
    case Target::segment: return segments(machine);
    case Target::volume:
      for (const mesh::VolumeSpec& volume : machine.volumes) items.push_back({volume.id, volume.capacity.std_percent});
      break;
    case Target::exchange: return exchanges(machine);
    case Target::body: return materials_and_bodies(machine, kind);
    case Target::scale:
      for (const mesh::ScaleSpec& scale : machine.scales) items.push_back({scale.axis, scale.expansion.std_percent});
      break;
    case Target::screw:
      for (const mesh::ScrewSpec& screw : machine.screws) items.push_back({screw.axis, screw.expansion.std_percent});
      break;
    case Target::nothing:
    case Target::sensor:
    case Target::reading: break;
  }
  return items;
}

/// The causes of the kind that a diagnosis offers for the item: of a material, those of its bodies.
const Parameter* offered(const std::vector<Parameter>& all, const mesh::Machine& machine, Kind kind,
                         const std::string& id) {
  for (const Parameter& one : all) {
    if (one.kind != kind) continue;
    const int body = machine.body_index(one.where);
    const bool of_material = diagnosis::row_of(kind).target == Target::body && body >= 0 &&
                             machine.bodies[body].material == id && machine.body_index(id) < 0;
    if (one.where == id || of_material) return &one;
  }
  return nullptr;
}

}  // namespace

std::vector<Item> items_of(const mesh::Machine& machine, Kind kind) {
  const std::vector<Parameter> all = diagnosis::candidate_parameters(machine, {}, true);
  std::vector<Item> items;
  for (Item& item : items_of_table(machine, kind)) {
    const Parameter* parameter = offered(all, machine, kind, item.id);
    if (parameter == nullptr) continue;
    item.low = parameter->low;
    item.high = parameter->high;
    items.push_back(std::move(item));
  }
  return items;
}

std::vector<std::string> kinds_of_plans() {
  std::vector<std::string> names;
  for (const diagnosis::KindRow& row : diagnosis::known_kinds()) {
    const bool acts = row.effect != Effect::readings && row.effect != Effect::timing;
    if (acts && row.target != Target::nothing && row.kind != Kind::source_missing && !diagnosis::is_step(row.kind))
      names.push_back(row.name);
  }
  return names;
}

bool shares_matrices(Kind kind) {
  const Effect effect = diagnosis::row_of(kind).effect;
  return effect == Effect::coefficient || effect == Effect::heat;
}

}  // namespace thermotwin::study
