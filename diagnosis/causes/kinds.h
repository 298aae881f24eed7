// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The kinds of causes. One row per kind holds everything that the program knows about it.

#include <optional>
#include <string>
#include <vector>

namespace thermotwin::diagnosis {

enum class Kind {
  source_power,
  source_missing,
  source_speed_law,
  standstill_power,
  process_heat,
  source_step,
  film_coefficient,
  film_speed_law,
  film_emissivity,
  radiation_load,
  ambient_offset,
  ambient_gradient,
  foundation_temperature,
  cutting_fluid,
  contact_conductance,
  contact_stiffness,
  contact_pressure,
  contact_step,
  coolant_flow,
  coolant_coupling,
  coolant_inlet,
  control_sensor_offset,
  volume_exchange,
  volume_capacity,
  expansion_coefficient,
  heat_capacity,
  scale_expansion,
  screw_expansion,
  sensor_offset,
  sensor_drift,
  sensor_lag,
  sensor_detached,
  probe_drift,
  clock_shift,
  unmeasured_temperature,  ///< this and the next: only of records without a machine, data_hypotheses.h
  time_constant,
  other_law,  ///< a source or joint that changes in the course of a record: no value of machine.toml has its law
  none,       ///< no cause
  unknown
};

/// The item that carries the value: a table of machine.toml, a body's own material, a reading of a channel.
enum class Target {
  nothing,
  source,
  film,
  ambient,
  joint,
  coolant,
  segment,
  volume,
  exchange,
  body,
  scale,
  screw,
  sensor,
  reading
};

enum class Sense { ratio, absolute };  ///< the value multiplies the nominal one, or is added to it

enum class Effect {
  coefficient,  ///< a coefficient of the equation
  heat,         ///< heat that enters somewhere, and nothing else
  part,         ///< the share of a body, joint, scale or screw in the matrices: see parameter_sizes.h
  readings,     ///< changes the reading, not the machine; needs no run of the model
  timing        ///< changes the time of a reading; the effect is far from linear in the parameter
};

struct KindRow {
  Kind kind;
  std::string name, where;  ///< name in files and texts; what `where` refers to
  Target target;
  std::string key;           ///< key of machine.toml that holds the value; for a few exceptions see hypothesis.cpp
  double per_unit;           ///< value in mesh::Machine (SI) of one unit of the key
  std::string amount, unit;  ///< name and unit of the kind's parameter
  Sense sense;
  double low, high, step;  ///< bounds and step of the finite difference
  Effect effect;
};

const KindRow& row_of(Kind kind);
/// @return the kinds that a machine and its measurement can offer, as diagnosis/README.md lists them
const std::vector<KindRow>& known_kinds();

inline const std::string& name_of(Kind kind) { return row_of(kind).name; }
/// @return one of known_kinds(); nothing if no kind has this name
std::optional<Kind> find_kind(const std::string& name);
/// @throws InputError for an unknown kind
Kind kind_named(const std::string& name);

inline bool adds_heat(Kind kind) { return row_of(kind).effect == Effect::heat; }
inline bool needs_parts(Kind kind) { return row_of(kind).effect == Effect::part; }
/// @return whether the parameter acts only from a time of the record on, Parameter::from_s
inline bool is_step(Kind kind) { return kind == Kind::source_step || kind == Kind::contact_step; }
inline bool acts_in_time(Kind kind) { return row_of(kind).effect == Effect::timing; }
inline bool acts_on_readings(Kind kind) { return row_of(kind).effect == Effect::readings || acts_in_time(kind); }

}  // namespace thermotwin::diagnosis
