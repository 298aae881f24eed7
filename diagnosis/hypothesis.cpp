// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/hypothesis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/error.h"
#include "core/text.h"
#include "diagnosis/machine_text.h"
#include "diagnosis/machine_value.h"

namespace thermotwin::diagnosis {

using core::InputError;
using mesh::Machine;

namespace {

/// What a value is uncertain by at least, though the file states less: no machine is exact, and a
/// coarse mesh makes a contact or a film worse by some percent.
constexpr double least_source_std = 0.03, least_film_std = 0.05, least_contact_std = 0.10;
constexpr double least_offset_std = 0.1;  ///< K, air beside the structure against the channel

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

bool measures(const compensation::Measurement& measurement, const std::string& input) {
  return std::any_of(measurement.channels.begin(), measurement.channels.end(),
                     [&](const auto& channel) { return channel.input == input; });
}

/// A candidate: uncertain by nominal_std where the machine is right, by cause_std where it is wrong.
Parameter candidate(const std::string& kind, const std::string& where, double nominal_std, double cause_std) {
  Parameter p = make_parameter(kind, where);
  p.nominal_std = nominal_std;
  p.cause_std = std::max(cause_std, 3.0 * p.nominal_std);
  return p;
}

Parameter ratio(const std::string& kind, const std::string& where, const core::Uncertain& nominal,
                double least_std, double cause_std) {
  return candidate(kind, where, std::max(nominal.std_percent / 100.0, least_std), cause_std);
}

/// An ambient whose own channel is measured does not follow: its offset then acts nowhere.
bool offset_acts(const mesh::AmbientSpec& ambient, const compensation::Measurement& measurement) {
  return ambient.follows.empty() || !measures(measurement, ambient.id + ".T_C");
}

}  // namespace

const std::vector<Kind>& known_kinds() {
  static const std::vector<Kind> kinds = {
      {"source_power", "id of a [[source]]", "factor", "1", "ratio"},
      {"film_coefficient", "id of a [[film]]", "factor", "1", "ratio"},
      {"contact_conductance", "id of a [[joint]]", "factor", "1", "ratio"},
      {"ambient_offset", "id of an [[ambient]]", "offset", "K", "absolute"},
      {"coolant_flow", "id of a [[coolant]]", "factor", "1", "ratio"},
      {"coolant_coupling", "<coolant>.<segment> of a [[coolant.segment]]", "factor", "1", "ratio"},
      {"control_sensor_offset", "id of a [[coolant]]", "offset", "K", "absolute"},
      {"sensor_offset", "id of a measured channel", "offset", "K", "absolute"},
  };
  return kinds;
}

Parameter make_parameter(const std::string& kind, const std::string& where) {
  std::vector<std::string> known;
  for (const Kind& k : known_kinds()) {
    known.push_back(k.kind);
    if (k.kind != kind) continue;
    Parameter p;
    p.kind = kind;
    p.where = where;
    p.name = k.name;
    p.unit = k.unit;
    const bool is_ratio = k.sense == "ratio";
    p.nominal = is_ratio ? 1.0 : 0.0;
    p.low = is_ratio ? 0.0 : -30.0;
    p.high = is_ratio ? 8.0 : 30.0;
    return p;
  }
  throw InputError("diagnosis", "kind '" + kind + "'", "one of: " + core::join(known));
}

std::vector<Parameter> candidate_parameters(const Machine& machine,
                                            const compensation::Measurement& measurement) {
  std::vector<Parameter> found;
  for (const auto& source : machine.sources)
    found.push_back(ratio("source_power", source.id, source.scale, least_source_std, 0.6));
  for (const auto& film : machine.films)
    found.push_back(ratio("film_coefficient", film.id, film.coefficient, least_film_std, 0.8));
  for (const auto& joint : machine.joints)
    if (joint.conductance.value > 0.0)
      found.push_back(ratio("contact_conductance", joint.id, joint.conductance, least_contact_std, 0.8));
  for (const auto& ambient : machine.ambients) {
    if (!offset_acts(ambient, measurement)) continue;
    double std = least_offset_std;
    for (const auto& channel : measurement.channels)
      if (channel.input == ambient.id + ".T_C") std = std::max(std, channel.uncertainty);
    // Where nothing is measured, the file's own uncertainty of the temperature is what counts.
    if (!measures(measurement, ambient.id + ".T_C"))
      std = std::max(std, std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0);
    found.push_back(candidate("ambient_offset", ambient.id, std, 2.0));
  }
  for (const auto& coolant : machine.coolants) {
    found.push_back(ratio("coolant_flow", coolant.id, coolant.flow, least_source_std, 0.5));
    for (const auto& segment : coolant.segments)
      found.push_back(ratio("coolant_coupling", coolant.id + "." + segment.id, segment.film_coefficient,
                            least_contact_std, 0.6));
    if (!measures(measurement, "coolant." + coolant.id + ".inlet_T_C"))
      found.push_back(candidate("control_sensor_offset", coolant.id, least_offset_std, 2.0));
  }
  for (const auto& channel : measurement.channels) {
    if (channel.kind != compensation::ChannelKind::temperature || channel.sensor.empty()) continue;
    if (machine.sensor_index(channel.sensor) < 0) continue;
    found.push_back(candidate("sensor_offset", channel.id, std::max(channel.uncertainty, 0.01), 2.0));
    found.back().item = channel.sensor;
  }
  return found;
}

MachineValue machine_value(Machine& machine, const Parameter& parameter) {
  const std::string& id = parameter.item.empty() ? parameter.where : parameter.item;
  const std::string& kind = parameter.kind;
  if (kind == "source_power")
    return {"source", id, "", "scale", &find_item(machine.sources, id, kind)->scale.value};
  if (kind == "film_coefficient") {
    mesh::FilmSpec* film = find_item(machine.films, id, kind);
    const bool constant = film->kind == mesh::FilmKind::constant;
    return {"film", id, "", constant ? "film_coefficient_W_m2K" : "factor", &film->coefficient.value};
  }
  if (kind == "contact_conductance")
    return {"joint", id, "", "conductance_W_m2K", &find_item(machine.joints, id, kind)->conductance.value};
  if (kind == "ambient_offset")
    return {"ambient", id, "", "offset_K", &find_item(machine.ambients, id, kind)->offset};
  if (kind == "coolant_flow")
    return {"coolant", id, "", "flow_kg_s", &find_item(machine.coolants, id, kind)->flow.value};
  if (kind == "control_sensor_offset")
    return {"coolant", id, "", "guide_offset_K", &find_item(machine.coolants, id, kind)->guide_offset};
  if (kind == "sensor_offset")
    return {"sensor", id, "", "offset_K", &find_item(machine.sensors, id, kind)->offset};
  if (kind == "coolant_coupling") {
    // Ids may hold dots themselves: the coolant is the one whose id the name begins with.
    for (auto& coolant : machine.coolants)
      for (auto& segment : coolant.segments)
        if (coolant.id + "." + segment.id == id)
          return {"coolant", coolant.id, segment.id, "film_coefficient_W_m2K",
                  &segment.film_coefficient.value};
    throw InputError("diagnosis", "coolant_coupling of '" + id + "'", "<coolant>.<segment> of the machine");
  }
  make_parameter(kind, id);  // says which kinds there are
  throw std::logic_error("kind '" + kind + "' is listed but changes nothing");
}

double changed_value(double in_file, const Parameter& parameter, double value) {
  // Nine digits are what a file should carry: 12.184, not 12.184000000000001.
  const double exact = parameter.unit == "1" ? in_file * value : in_file + value;
  return std::stod(fmt::format("{:.9g}", exact));
}

Machine with_parameter(const Machine& machine, const Parameter& parameter, double value) {
  Machine changed = machine;
  double& number = *machine_value(changed, parameter).value;
  number = changed_value(number, parameter, value);
  if (parameter.kind == "ambient_offset") shift_defaults(machine, changed);
  return changed;
}

std::string extended_text(const Machine& machine, const Parameter& parameter, double value, double std,
                          const std::string& why) {
  Machine copy = machine;
  const MachineValue place = machine_value(copy, parameter);
  const std::string unit = parameter.unit == "1" ? "" : " " + parameter.unit;
  std::string comment = fmt::format("diagnosis: {} {} {:.4g}{} +- {:.2g}{}, was {:.9g}", parameter.kind,
                                    parameter.name, value, unit, std, unit, *place.value);
  if (!why.empty()) comment += "; " + why;
  return changed_text(machine.text, machine.path.string(), place,
                      changed_value(*place.value, parameter, value), comment);
}

}  // namespace thermotwin::diagnosis
