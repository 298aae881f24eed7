// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/hypothesis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error.h"
#include "core/text.h"
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
  throw InputError("diagnosis", kind + " of '" + axis + "'", "an axis of the machine that has one");
}

mesh::ReadingSpec& reading_of(Machine& machine, const std::string& id) {
  for (mesh::ReadingSpec& reading : machine.readings)
    if (reading.id == id) return reading;
  machine.readings.push_back({.id = id});
  return machine.readings.back();
}

constexpr double hour = 3600.0;

std::vector<MachineValue> source_value(Machine& machine, const std::string& kind, const std::string& id) {
  mesh::SourceSpec* source = find_item(machine.sources, id, kind);
  if (kind == "source_speed_law") return {{"source", id, "", "speed_exponent", &source->speed_exponent}};
  if (kind == "standstill_power") return {{"source", id, "", "standstill_W", &source->standstill}};
  return {{"source", id, "", "scale", &source->scale.value}};
}

std::vector<MachineValue> film_value(Machine& machine, const std::string& kind, const std::string& id) {
  mesh::FilmSpec* film = find_item(machine.films, id, kind);
  if (kind == "film_speed_law") return {{"film", id, "", "speed_factor", &film->speed_factor}};
  if (kind == "radiation_load") return {{"film", id, "", "radiation_load_W_m2", &film->radiation_load}};
  const bool constant = film->kind == mesh::FilmKind::constant;
  return {{"film", id, "", constant ? "film_coefficient_W_m2K" : "factor", &film->coefficient.value}};
}

std::vector<MachineValue> joint_value(Machine& machine, const std::string& kind, const std::string& id) {
  mesh::JointSpec* joint = find_item(machine.joints, id, kind);
  if (kind == "contact_conductance") return {{"joint", id, "", "conductance_W_m2K", &joint->conductance.value}};
  std::vector<MachineValue> both{{"joint", id, "", "stiffness_normal_N_mm3", &joint->stiffness_normal.value, 1e9}};
  if (joint->stiffness_tangential.value > 0.0)
    both.push_back({"joint", id, "", "stiffness_tangential_N_mm3", &joint->stiffness_tangential.value, 1e9});
  return both;
}

std::vector<MachineValue> coolant_value(Machine& machine, const std::string& kind, const std::string& id) {
  if (kind == "coolant_coupling") {
    // Ids may hold dots themselves: the coolant is the one whose id the name begins with.
    for (auto& coolant : machine.coolants)
      for (auto& segment : coolant.segments)
        if (coolant.id + "." + segment.id == id)
          return {{"coolant", coolant.id, segment.id, "film_coefficient_W_m2K", &segment.film_coefficient.value}};
    throw InputError("diagnosis", "coolant_coupling of '" + id + "'", "<coolant>.<segment> of the machine");
  }
  mesh::CoolantSpec* coolant = find_item(machine.coolants, id, kind);
  if (kind == "coolant_flow") return {{"coolant", id, "", "flow_kg_s", &coolant->flow.value}};
  if (kind == "coolant_inlet") return {{"coolant", id, "", "inlet_offset_K", &coolant->inlet_offset}};
  return {{"coolant", id, "", "guide_offset_K", &coolant->guide_offset}};
}

std::vector<MachineValue> part_value(Machine& machine, const std::string& kind, const std::string& id) {
  if (kind == "scale_expansion")
    return {{"scale", id, "", "expansion_1_K", &find_axis(machine.scales, id, kind)->expansion.value, 1.0, "axis"}};
  if (kind == "screw_expansion")
    return {{"screw", id, "", "expansion_1_K", &find_axis(machine.screws, id, kind)->expansion.value, 1.0, "axis"}};
  mesh::Material& material = own_material(machine, *find_item(machine.bodies, id, kind));
  if (kind == "expansion_coefficient")
    return {{"material", material.id, "", "expansion_1_K", &material.expansion.value}};
  return {{"material", material.id, "", "specific_heat_J_kgK", &material.specific_heat.value}};
}

bool guides_chiller(const Machine& machine, const std::string& sensor) {
  return std::any_of(machine.coolants.begin(), machine.coolants.end(),
                     [&](const mesh::CoolantSpec& c) { return c.guide_sensor == sensor; });
}

/// @param channel  where the reading is recorded
std::vector<MachineValue> reading_value(Machine& machine, const std::string& kind, const std::string& id,
                                        const std::string& channel) {
  if (kind == "probe_drift")
    return {{"reading", id, "", "drift_1_h", &reading_of(machine, id).drift, 1.0 / hour, "id", true}};
  if (kind == "clock_shift") return {{"reading", id, "", "shift_s", &reading_of(machine, id).shift, 1.0, "id", true}};
  mesh::SensorSpec* sensor = find_item(machine.sensors, id, kind);
  if (kind == "sensor_drift") return {{"sensor", id, "", "drift_K_h", &sensor->drift, 1.0 / hour}};
  if (kind == "sensor_lag") return {{"sensor", id, "", "time_constant_s", &sensor->lag}};
  if (kind == "sensor_detached") return {{"sensor", id, "", "air_share", &sensor->air_share}};
  // The offset of a guiding sensor acts on the machine; what a record alone is off by does not.
  if (guides_chiller(machine, id))
    return {{"reading", channel, "", "offset", &reading_of(machine, channel).offset, 1.0, "id", true}};
  return {{"sensor", id, "", "offset_K", &sensor->offset}};
}

}  // namespace

std::string own_material_id(const Machine& machine, const mesh::BodySpec& body) {
  int users = 0;
  for (const mesh::BodySpec& other : machine.bodies) users += other.material == body.material;
  return users < 2 ? body.material : body.material + "." + body.id;
}

std::vector<MachineValue> machine_values(Machine& machine, const Parameter& parameter) {
  const std::string& id = parameter.item.empty() ? parameter.where : parameter.item;
  const std::string& kind = parameter.kind;
  make_parameter(kind, id);  // says which kinds there are
  if (kind.starts_with("source_") || kind == "standstill_power" || kind == "process_heat")
    return source_value(machine, kind, id);
  if (kind.starts_with("film_") || kind == "radiation_load") return film_value(machine, kind, id);
  if (kind == "ambient_gradient")
    return {{"ambient", id, "", "gradient_K_m", &find_item(machine.ambients, id, kind)->gradient.value}};
  if (kind.starts_with("ambient_") || kind == "foundation_temperature" || kind == "cutting_fluid")
    return {{"ambient", id, "", "offset_K", &find_item(machine.ambients, id, kind)->offset}};
  if (kind.starts_with("contact_")) return joint_value(machine, kind, id);
  if (kind.starts_with("coolant_") || kind == "control_sensor_offset") return coolant_value(machine, kind, id);
  return needs_parts(kind) ? part_value(machine, kind, id) : reading_value(machine, kind, id, parameter.where);
}

double changed_value(double in_file, const Parameter& parameter, double value) {
  // Nine digits are what a file should carry: 12.184, not 12.184000000000001.
  const double exact = parameter.ratio ? in_file * value : in_file + value;
  return std::stod(fmt::format("{:.9g}", exact));
}

Machine with_parameter(const Machine& machine, const Parameter& parameter, double value) {
  if (parameter.missing) return with_missing_source(machine, parameter, value);
  Machine changed = machine;
  for (const MachineValue& place : machine_values(changed, parameter))
    *place.value = place.per_unit * changed_value(*place.value / place.per_unit, parameter, value);
  if (parameter.kind == "ambient_offset" || parameter.kind == "foundation_temperature" ||
      parameter.kind == "cutting_fluid")
    shift_defaults(machine, changed);
  return changed;
}

std::string extended_text(const Machine& machine, const Parameter& parameter, double value, double std,
                          const std::string& why) {
  if (parameter.missing) return missing_source_text(machine, parameter, value, std, why);
  Machine copy = machine;
  std::string text = machine.text;
  const std::vector<MachineValue> places = machine_values(copy, parameter);
  if (copy.materials.size() > machine.materials.size())
    text = with_own_material(
        text, machine.path.string(),
        machine.body_index(parameter.where) >= 0 ? machine.bodies[machine.body_index(parameter.where)].material : "",
        copy.materials.back().id, parameter.where);
  for (const MachineValue& place : places) {
    const std::string unit = parameter.unit == "1" ? "" : " " + parameter.unit;
    const double was = *place.value / place.per_unit;
    std::string comment = fmt::format("diagnosis: {} {} {:.4g}{} +- {:.2g}{}, was {:.9g}", parameter.kind,
                                      parameter.name, value, unit, std, unit, was);
    if (!why.empty()) comment += "; " + why;
    text = changed_text(text, machine.path.string(), place, changed_value(was, parameter, value), comment);
  }
  return text;
}

}  // namespace thermotwin::diagnosis
