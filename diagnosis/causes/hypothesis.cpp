// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/hypothesis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "core/error.h"
#include "core/text.h"
#include "diagnosis/causes/exchange_ids.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_text.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/missing_source.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

using core::InputError;
using mesh::Machine;

namespace {

template <class Items>
auto* find_item(Items& items, const std::string& id, const std::string& kind) {
  for (auto& item : items)
    if (item.id == id) return &item;
  std::vector<std::string> known;
  for (const auto& item : items) known.push_back(item.id);
  throw InputError("diagnosis", kind + " of '" + id + "'", "one of: " + core::join(known));
}

/// Temperature that an ambient takes by the file alone, with the offsets on the way.
double chain_default(const Machine& machine, const mesh::AmbientSpec& ambient) {
  const mesh::AmbientSpec* at = &ambient;
  double offset = 0.0;
  for (std::size_t i = 0; i < machine.ambients.size() && !at->follows.empty(); ++i) {
    offset += at->offset;
    at = find_item(machine.ambients, at->follows, "ambient");
  }
  return at->default_C.value + offset;
}

/// An ambient that follows another has the default of the chain unless the file gives its own.
void shift_defaults(const Machine& before, Machine& after) {
  for (std::size_t i = 0; i < before.ambients.size(); ++i) {
    const mesh::AmbientSpec& old = before.ambients[i];
    if (old.follows.empty()) continue;
    if (std::abs(old.default_C.value - chain_default(before, old)) < 1e-9)
      after.ambients[i].default_C.value = chain_default(after, after.ambients[i]);
  }
}

std::string copy_id(const std::string& material, const mesh::BodySpec& body) { return material + "." + body.id; }

/// Bodies of one casting share a material in the file; the cause is one body's.
mesh::Material& own_material(Machine& machine, mesh::BodySpec& body) {
  const std::string id = own_material_id(machine, body);
  if (id != body.material) {
    mesh::Material copy = machine.material(body.material);
    copy.id = id;
    machine.materials.push_back(std::move(copy));
    body.material = id;
  }
  return *find_item(machine.materials, id, "material");
}

template <class Items>
auto* find_axis(Items& items, const std::string& axis, const std::string& kind) {
  for (auto& item : items)
    if (item.axis == axis) return &item;
  throw InputError("diagnosis", kind + " of '" + axis + "'",
                   "an axis with a linear scale or a ball screw in machine.toml");
}

mesh::ReadingSpec& reading_of(Machine& machine, const std::string& id) {
  for (mesh::ReadingSpec& reading : machine.readings)
    if (reading.id == id) return reading;
  machine.readings.push_back({.id = id});
  return machine.readings.back();
}

/// The numbers of an item that a kind may change.
double& field(mesh::SourceSpec& source, Kind kind) {
  if (kind == Kind::source_speed_law) return source.speed_exponent;
  return kind == Kind::standstill_power ? source.standstill : source.scale.value;
}
double& field(mesh::FilmSpec& film, Kind kind) {
  if (kind == Kind::film_speed_law) return film.speed_factor;
  if (kind == Kind::film_emissivity) return film.emissivity.value;
  return kind == Kind::radiation_load ? film.radiation_load : film.coefficient.value;
}
double& field(mesh::AmbientSpec& ambient, Kind kind) {
  return kind == Kind::ambient_gradient ? ambient.gradient.value : ambient.offset;
}
double& field(mesh::JointSpec& joint, Kind kind) {
  if (kind == Kind::contact_pressure) return joint.law.pressure.value;
  return kind == Kind::contact_stiffness ? joint.stiffness_normal.value : joint.conductance.value;
}
double& field(mesh::CoolantSpec& coolant, Kind kind) {
  if (kind == Kind::coolant_flow) return coolant.flow.value;
  return kind == Kind::coolant_inlet ? coolant.inlet_offset : coolant.guide_offset;
}
double& field(mesh::Material& material, Kind kind) {
  return kind == Kind::expansion_coefficient ? material.expansion.value : material.specific_heat.value;
}
double& field(mesh::SensorSpec& sensor, Kind kind) {
  if (kind == Kind::sensor_drift) return sensor.drift;
  if (kind == Kind::sensor_lag) return sensor.lag;
  return kind == Kind::sensor_detached ? sensor.air_share : sensor.offset;
}
double& field(mesh::ReadingSpec& reading, Kind kind) {
  if (kind == Kind::probe_drift || kind == Kind::sensor_drift) return reading.drift;
  return kind == Kind::clock_shift ? reading.shift : reading.offset;
}

/// The row's own key in the table of the item.
template <class Item>
MachineValue value_of(Item& item, const std::string& table, const std::string& id, const KindRow& row) {
  return {table, id, "", row.key, &field(item, row.kind), row.per_unit};
}

template <class Items>
MachineValue value_in(Items& items, const std::string& table, const std::string& id, const KindRow& row) {
  return value_of(*find_item(items, id, row.name), table, id, row);
}

template <class Items>
MachineValue axis_value(Items& items, const std::string& table, const std::string& axis, const KindRow& row) {
  MachineValue value{table, axis, "", row.key, &find_axis(items, axis, row.name)->expansion.value};
  value.id_key = "axis";
  return value;
}

MachineValue film_value(Machine& machine, const std::string& id, const KindRow& row) {
  MachineValue value = value_in(machine.films, "film", id, row);
  const bool by_law = find_item(machine.films, id, row.name)->kind != mesh::FilmKind::constant;
  if (row.kind == Kind::film_coefficient && by_law) value.key = "factor";
  return value;
}

std::vector<MachineValue> joint_values(Machine& machine, const std::string& id, const KindRow& row) {
  std::vector<MachineValue> values{value_in(machine.joints, "joint", id, row)};
  core::Uncertain& tangential = find_item(machine.joints, id, row.name)->stiffness_tangential;
  if (row.kind == Kind::contact_stiffness && tangential.value > 0.0)
    values.push_back({"joint", id, "", "stiffness_tangential_N_mm3", &tangential.value, row.per_unit});
  return values;
}

MachineValue segment_value(Machine& machine, const std::string& id, const KindRow& row) {
  // Ids may hold dots themselves: the coolant is the one whose id the name begins with.
  for (auto& coolant : machine.coolants) {
    for (auto& segment : coolant.segments) {
      if (coolant.id + "." + segment.id == id)
        return {"coolant", coolant.id, segment.id, row.key, &segment.film_coefficient.value};
    }
  }
  throw InputError("diagnosis", row.name + " of '" + id + "'", "<coolant>.<segment> of the machine");
}

MachineValue exchange_value(Machine& machine, const std::string& id, const KindRow& row) {
  for (mesh::VolumeSpec& volume : machine.volumes) {
    const std::vector<std::string> ids = exchange_ids(volume);
    const std::size_t at = std::find(ids.begin(), ids.end(), id) - ids.begin();
    if (at == ids.size()) continue;
    mesh::VolumeExchange& exchange = volume.exchanges[at];
    MachineValue value{"volume", volume.id, exchange.with, row.key, &exchange.conductance.value};
    value.part_table = "exchange";
    value.part_key = "with";
    for (std::size_t i = 0; i < at; ++i) value.part_number += volume.exchanges[i].with == exchange.with;
    return value;
  }
  throw InputError("diagnosis", row.name + " of '" + id + "'",
                   "<volume>.<with> of the machine, of several with the same partner <volume>.<with>.<state>");
}

/// A volume states its content or its capacity; the machine knows the capacity, which is in proportion.
MachineValue volume_value(Machine& machine, const std::string& id, const KindRow& row) {
  mesh::VolumeSpec& volume = *find_item(machine.volumes, id, row.name);
  if (volume.capacity_per_litre > 0.0)
    return {"volume", id, "", row.key, &volume.capacity.value, volume.capacity_per_litre};
  return {"volume", id, "", "heat_capacity_J_K", &volume.capacity.value};
}

/// Of one body, or of a material in all its bodies. A body may have got a copy of it before.
std::vector<MachineValue> material_values(Machine& machine, const std::string& id, const KindRow& row) {
  const std::vector<const mesh::BodySpec*> bodies = bodies_of_material(machine, id);
  if (machine.body_index(id) >= 0 || bodies.empty()) {
    mesh::Material& material = own_material(machine, *find_item(machine.bodies, id, row.name));
    return {value_of(material, "material", material.id, row)};
  }
  std::set<std::string> ids;
  for (const mesh::BodySpec* body : bodies) ids.insert(body->material);
  std::vector<MachineValue> values;
  for (const std::string& material : ids) values.push_back(value_in(machine.materials, "material", material, row));
  return values;
}

MachineValue reading_value(Machine& machine, const std::string& id, const KindRow& row) {
  MachineValue value = value_of(reading_of(machine, id), "reading", id, row);
  value.may_lack = true;
  return value;
}

bool guides_chiller(const Machine& machine, const std::string& sensor) {
  return std::any_of(machine.coolants.begin(), machine.coolants.end(),
                     [&](const mesh::CoolantSpec& c) { return c.guide_sensor == sensor; });
}

/// Of a sensor: offset or drift of what a record shows.
MachineValue recorded_value(Machine& machine, const std::string& channel, const KindRow& row) {
  MachineValue recorded = reading_value(machine, channel, row);
  recorded.key = row.kind == Kind::sensor_drift ? "drift_1_h" : "offset";
  return recorded;
}

MachineValue sensor_value(Machine& machine, const std::string& id, const Parameter& parameter, const KindRow& row) {
  const MachineValue value = value_in(machine.sensors, "sensor", id, row);
  // The offset of a guiding sensor acts on the machine; what a record alone is off by does not.
  const bool recorded = parameter.of_record || (row.kind == Kind::sensor_offset && guides_chiller(machine, id));
  return recorded ? recorded_value(machine, parameter.where, row) : value;
}

}  // namespace

std::string own_material_id(const Machine& machine, const mesh::BodySpec& body) {
  int users = 0;
  for (const mesh::BodySpec& other : machine.bodies) users += other.material == body.material;
  return users < 2 ? body.material : copy_id(body.material, body);
}

std::vector<const mesh::BodySpec*> bodies_of_material(const Machine& machine, const std::string& material) {
  std::vector<const mesh::BodySpec*> bodies;
  for (const mesh::BodySpec& body : machine.bodies)
    if (body.material == material || body.material == copy_id(material, body)) bodies.push_back(&body);
  return bodies;
}

std::vector<MachineValue> machine_values(Machine& machine, const Parameter& parameter) {
  const std::string& id = parameter.item.empty() ? parameter.where : parameter.item;
  const KindRow& row = row_of(parameter.kind);
  switch (row.target) {
    case Target::source: return {value_in(machine.sources, "source", id, row)};
    case Target::film: return {film_value(machine, id, row)};
    case Target::ambient: return {value_in(machine.ambients, "ambient", id, row)};
    case Target::joint: return joint_values(machine, id, row);
    case Target::coolant: return {value_in(machine.coolants, "coolant", id, row)};
    case Target::segment: return {segment_value(machine, id, row)};
    case Target::volume: return {volume_value(machine, id, row)};
    case Target::exchange: return {exchange_value(machine, id, row)};
    case Target::body: return material_values(machine, id, row);
    case Target::scale: return {axis_value(machine.scales, "scale", id, row)};
    case Target::screw: return {axis_value(machine.screws, "screw", id, row)};
    case Target::sensor: return {sensor_value(machine, id, parameter, row)};
    case Target::reading: return {reading_value(machine, id, row)};
    case Target::nothing: break;
  }
  throw InputError("diagnosis", "kind '" + row.name + "'", "a kind of cause that changes a value of machine.toml");
}

double changed_value(double in_file, const Parameter& parameter, double value) {
  // 11e-6 times 1.2 is 1.32e-5, as a file has it, and not the number beside it.
  return std::stod(fmt::format("{:.15g}", parameter.ratio ? in_file * value : in_file + value));
}

/// Nine digits are what a file should carry: 12.184, not 12.184000000000001.
double value_for_file(double in_file, const Parameter& parameter, double value) {
  return std::stod(fmt::format("{:.9g}", changed_value(in_file, parameter, value)));
}

MachineInTime with_parameter(const MachineInTime& machine, const Parameter& parameter, double value) {
  MachineInTime changed = machine;
  if (parameter.missing) {
    static_cast<Machine&>(changed) = with_missing_source(machine, parameter, value);
    return changed;
  }
  if (is_step(parameter.kind) && std::isfinite(parameter.from_s)) {
    machine_values(changed, parameter);  // there is such an item
    changed.later.push_back({parameter.where, row_of(parameter.kind).target == Target::joint, value, parameter.from_s});
    return changed;
  }
  for (const MachineValue& place : machine_values(changed, parameter))
    *place.value = place.per_unit * changed_value(*place.value / place.per_unit, parameter, value);
  if (row_of(parameter.kind).target == Target::ambient && parameter.kind != Kind::ambient_gradient)
    shift_defaults(machine, changed);
  return changed;
}

std::string extended_text(const Machine& machine, const Parameter& parameter, double value, double std,
                          const std::string& why) {
  if (parameter.missing) return missing_source_text(machine, parameter, value, std, why);
  Machine copy = machine;
  std::string text = machine.text;
  const std::vector<MachineValue> places = machine_values(copy, parameter);
  if (copy.materials.size() > machine.materials.size()) {
    text = with_own_material(
        text, machine.path.string(),
        machine.body_index(parameter.where) >= 0 ? machine.bodies[machine.body_index(parameter.where)].material : "",
        copy.materials.back().id, parameter.where);
  }
  for (const MachineValue& place : places) {
    const std::string unit = parameter.unit == "1" ? "" : " " + parameter.unit;
    const double was = *place.value / place.per_unit;
    std::string comment =
        fmt::format("diagnosis: {} {} {}{} +- {}{}, was {:.9g}", name_of(parameter.kind), parameter.name,
                    core::plain_number(value, 4), unit, core::plain_number(std, 2), unit, was);
    if (is_step(parameter.kind)) comment += "; since " + step_in_words(parameter);
    if (!why.empty()) comment += "; " + why;
    text = changed_text(text, machine.path.string(), place, value_for_file(was, parameter, value), comment);
  }
  return text;
}

}  // namespace thermotwin::diagnosis
