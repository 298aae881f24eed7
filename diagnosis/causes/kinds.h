// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The kinds of causes: one row each, and all that the program knows of a kind by its name.

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
  film_coefficient,
  film_speed_law,
  radiation_load,
  ambient_offset,
  ambient_gradient,
  foundation_temperature,
  cutting_fluid,
  contact_conductance,
  contact_stiffness,
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
  unmeasured_temperature,  ///< this one and the next of records without a machine, data_hypotheses.h
  time_constant,
  none,  ///< nothing changed
  unknown
};

/// What carries the value: a table of machine.toml, a material of the body's own, a reading of a channel.
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

enum class Sense { ratio, absolute };  ///< the nominal value is multiplied; it is added to

enum class Effect {
  coefficient,  ///< of the equation
  heat,         ///< heat that enters somewhere, and nothing else
  part,         ///< matrices of single bodies, joints, scales or screws: see parameter_sizes.h
  readings,     ///< what is read, not what the machine does: no run of the model is needed
  timing        ///< of readings, when something is read: far from linear
};

struct KindRow {
  Kind kind;
  std::string name, where;  ///< in files and in words; what `where` refers to, in words
  Target target;
  std::string key;           ///< in machine.toml that takes the value; a few items have another one, see hypothesis.cpp
  double per_unit;           ///< the machine's value of one unit of the key
  std::string amount, unit;  ///< name and unit of the one parameter
  Sense sense;
  double low, high, step;  ///< bounds, step of the finite difference
  Effect effect;
};

const KindRow& row_of(Kind kind);
/// The kinds that a machine and its measurement can offer, as README.md lists them.
const std::vector<KindRow>& known_kinds();

inline const std::string& name_of(Kind kind) { return row_of(kind).name; }
/// One of known_kinds(); none where no kind has this name.
std::optional<Kind> find_kind(const std::string& name);
/// @throws InputError: unknown kind
Kind kind_named(const std::string& name);

inline bool adds_heat(Kind kind) { return row_of(kind).effect == Effect::heat; }
inline bool needs_parts(Kind kind) { return row_of(kind).effect == Effect::part; }
inline bool acts_in_time(Kind kind) { return row_of(kind).effect == Effect::timing; }
inline bool acts_on_readings(Kind kind) { return row_of(kind).effect == Effect::readings || acts_in_time(kind); }

}  // namespace thermotwin::diagnosis
