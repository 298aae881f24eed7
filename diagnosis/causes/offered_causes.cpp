// SPDX-License-Identifier: GPL-3.0-or-later
// What a machine and a measurement offer as causes, with how uncertain each is by itself and how far
// off it may be where it is the cause.

#include "diagnosis/causes/offered_causes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compensation/measurement/channel.h"
#include "diagnosis/causes/exchange_ids.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

using compensation::ChannelKind;
using compensation::MeasuredChannel;
using compensation::Measurement;
using mesh::Machine;

namespace {

/// What a value is uncertain by at least, though the file states less: no machine is exact, and a
/// coarse mesh makes a contact or a film worse by some percent.
constexpr double least_source_std = 0.03, least_film_std = 0.05, least_contact_std = 0.10;
constexpr double least_emissivity_std = 0.03, least_pressure_std = 0.05;
constexpr double least_material_std = 0.01, least_stiffness_std = 0.15;
constexpr double of_each_body = 0.5;      ///< of a shared material's stated spread: bodies come from several melts
constexpr double least_offset_std = 0.1;  ///< K, air beside the structure against the channel
constexpr double exponent_std = 0.03;     ///< of laws of speeds
constexpr double least_standstill_std_W = 0.5;
constexpr double load_std_W_m2 = 1.0;  ///< lamps and warm neighbours that nobody draws
constexpr double gradient_std_K_m = 0.1;
constexpr double drift_std_K_h = 0.001, drift_std_um_h = 0.02, lag_std_s = 15.0, clock_std_s = 5.0;
constexpr double clock_share_of_row = 1.0 / 3.0;
constexpr double detached_std = 0.01;

/// Uncertain by nominal_std where the machine is right, by cause_std where it is wrong.
Parameter candidate(Kind kind, const std::string& where, double nominal_std, double cause_std) {
  Parameter p = make_parameter(kind, where);
  p.nominal_std = nominal_std;
  p.cause_std = std::max(cause_std, 3.0 * p.nominal_std);
  return p;
}

Parameter ratio(Kind kind, const std::string& where, const core::Uncertain& nominal, double least_std,
                double cause_std) {
  return candidate(kind, where, std::max(nominal.std_percent / 100.0, least_std), cause_std);
}

bool measures(const Measurement& measurement, const std::string& input) {
  return std::any_of(measurement.channels.begin(), measurement.channels.end(),
                     [&](const MeasuredChannel& channel) { return channel.input == input; });
}

bool is_speed(const std::string& input) { return compensation::channel_named(input).is_speed(); }

/// Without laws its power is known only where it is measured, and its drive is no axis: the cut.
bool is_process(const Machine& machine, const mesh::SourceSpec& source) {
  return !source.drive.empty() && source.laws.empty() && source.losses.empty() && source.drive != "spindle" &&
         machine.axis_index(source.drive) < 0;
}

/// A cabinet, lamps: `standstill_W` alone, which no scale multiplies.
bool only_stands(const mesh::SourceSpec& source) {
  return source.drive.empty() && source.laws.empty() && source.losses.empty();
}

double largest_power(const mesh::SourceSpec& source) {
  double most = 0.0;
  for (const mesh::PowerLaw& law : source.laws)
    for (const double power : law.power) most = std::max(most, std::abs(power));
  return most;
}

double standing_power(const mesh::SourceSpec& source) {
  double standing = source.standstill;
  for (const mesh::PowerLaw& law : source.laws)
    if (law.input == "machine.on") standing += source.scale.value * std::abs(law.power.back());
  return standing;
}

void add_sources(const Machine& machine, const Measurement& measurement, std::vector<Parameter>& found) {
  for (const mesh::SourceSpec& source : machine.sources) {
    if (is_process(machine, source)) {
      found.push_back(ratio(Kind::process_heat, source.id, source.scale, least_source_std, 1.0));
      continue;
    }
    if (only_stands(source)) {
      const double stated = std::abs(source.standstill),
                   share = std::max(source.scale.std_percent / 100.0, least_source_std);
      found.push_back(candidate(Kind::standstill_power, source.id, std::max(least_standstill_std_W, share * stated),
                                std::max(40.0, 0.6 * stated)));
      found.back().low = -std::max(0.0, source.standstill);
      continue;
    }
    found.push_back(ratio(Kind::source_power, source.id, source.scale, least_source_std, 0.6));
    const bool by_law = source.drive.empty() || !measures(measurement, source.drive + ".power_W");
    const bool by_speed = !source.losses.empty() || std::any_of(source.laws.begin(), source.laws.end(),
                                                                [](const auto& law) { return is_speed(law.input); });
    if (by_law && by_speed) found.push_back(candidate(Kind::source_speed_law, source.id, exponent_std, 0.7));
    // What is on with the machine and no more is one and the same for both.
    if (source.drive.empty() && source.losses.empty() && !source.laws.empty() &&
        std::all_of(source.laws.begin(), source.laws.end(), [](const auto& law) { return law.input == "machine.on"; }))
      continue;
    const double scale = largest_power(source);
    found.push_back(candidate(Kind::standstill_power, source.id, std::max(least_standstill_std_W, 0.01 * scale),
                              std::max(40.0, 0.4 * scale)));
    found.back().low = -std::max(0.0, standing_power(source));
  }
}

void add_films(const Machine& machine, std::vector<Parameter>& found) {
  for (const mesh::FilmSpec& film : machine.films) {
    found.push_back(ratio(Kind::film_coefficient, film.id, film.coefficient, least_film_std, 0.8));
    const bool by_speed = film.kind == mesh::FilmKind::rotating_disc ||
                          (film.kind == mesh::FilmKind::table && is_speed(film.table.input));
    if (by_speed) found.push_back(ratio(Kind::film_speed_law, film.id, film.coefficient, least_film_std, 0.8));
    if (film.emissivity.value > 0.0) {
      found.push_back(ratio(Kind::film_emissivity, film.id, film.emissivity, least_emissivity_std, 0.5));
      found.back().high = std::min(found.back().high, 1.0 / film.emissivity.value);
    }
    // What shines on a wetted surface comes with the fluid's film.
    if (film.state.empty() && machine.volume_index(film.ambient) < 0)
      found.push_back(candidate(Kind::radiation_load, film.id, load_std_W_m2, 60.0));
  }
}

/// An ambient whose own channel is measured does not follow: its offset then acts nowhere.
bool offset_acts(const mesh::AmbientSpec& ambient, const Measurement& measurement) {
  return ambient.follows.empty() || !measures(measurement, ambient.id + ".T_C");
}

/// The ambient's part decides the name: what mounts stand on, what cutting fluid wets, or air.
Kind offset_kind(const Machine& machine, const mesh::AmbientSpec& ambient) {
  for (const mesh::JointSpec& joint : machine.joints)
    if (joint.master.empty() && joint.ambient == ambient.id) return Kind::foundation_temperature;
  for (const mesh::FilmSpec& film : machine.films)
    if (film.ambient == ambient.id && film.state == "cutting_fluid.on") return Kind::cutting_fluid;
  return Kind::ambient_offset;
}

void add_ambients(const Machine& machine, const Measurement& measurement, std::vector<Parameter>& found) {
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    if (offset_acts(ambient, measurement)) {
      double std = least_offset_std;
      for (const MeasuredChannel& channel : measurement.channels)
        if (channel.input == ambient.id + ".T_C") std = std::max(std, channel.uncertainty);
      // Where nothing is measured, the file's own uncertainty of the temperature is what counts.
      if (!measures(measurement, ambient.id + ".T_C"))
        std = std::max(std, std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0);
      found.push_back(candidate(offset_kind(machine, ambient), ambient.id, std, 2.0));
    }
    if (ambient.has_gradient && !measures(measurement, ambient.id + ".gradient_K_m")) {
      found.push_back(candidate(
          Kind::ambient_gradient, ambient.id,
          std::max(gradient_std_K_m, std::abs(ambient.gradient.value) * ambient.gradient.std_percent / 100.0), 1.0));
    }
  }
}

void add_coolants(const Machine& machine, const Measurement& measurement, std::vector<Parameter>& found) {
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    found.push_back(ratio(Kind::coolant_flow, coolant.id, coolant.flow, least_source_std, 0.5));
    for (const mesh::CoolantSegment& segment : coolant.segments) {
      found.push_back(ratio(Kind::coolant_coupling, coolant.id + "." + segment.id, segment.film_coefficient,
                            least_contact_std, 0.6));
    }
    const bool measured = measures(measurement, "coolant." + coolant.id + ".inlet_T_C");
    found.push_back(
        candidate(measured ? Kind::coolant_inlet : Kind::control_sensor_offset, coolant.id, least_offset_std, 2.0));
  }
}

/// A volume whose temperature is measured has no heat balance.
bool balances(const mesh::VolumeSpec& volume, const Measurement& measurement) {
  return !measures(measurement, volume.id + ".T_C");
}

void add_volumes(const Machine& machine, const Measurement& measurement, std::vector<Parameter>& found) {
  for (const mesh::VolumeSpec& volume : machine.volumes) {
    if (!balances(volume, measurement)) continue;
    const std::vector<std::string> ids = exchange_ids(volume);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const core::Uncertain& conductance = volume.exchanges[i].conductance;
      if (conductance.value > 0.0)
        found.push_back(ratio(Kind::volume_exchange, ids[i], conductance, least_film_std, 0.8));
    }
  }
}

/// A value of a material is uncertain in all its bodies alike, and in each of them by some of that.
core::Uncertain of_body(core::Uncertain of_material, bool shared) {
  if (shared) of_material.std_percent *= of_each_body;
  return of_material;
}

/// Of every body, and of the materials that several bodies have.
void add_materials(const Machine& machine, std::vector<Parameter>& found) {
  std::set<std::string> growing, storing;  // bodies beside which a material is a cause of its own
  for (const mesh::Material& material : machine.materials) {
    if (machine.body_index(material.id) >= 0) continue;  // by its id it would be the body's
    std::vector<std::string> bodies, elastic;
    for (const mesh::BodySpec* body : bodies_of_material(machine, material.id)) {
      bodies.push_back(body->id);
      if (body->elastic) elastic.push_back(body->id);
    }
    if (elastic.size() > 1) {
      found.push_back(ratio(Kind::expansion_coefficient, material.id, material.expansion, least_material_std, 0.3));
      growing.insert(elastic.begin(), elastic.end());
    }
    if (bodies.size() > 1 && material.specific_heat_table.at.empty()) {
      found.push_back(ratio(Kind::heat_capacity, material.id, material.specific_heat, least_material_std, 0.3));
      storing.insert(bodies.begin(), bodies.end());
    }
  }
  for (const mesh::BodySpec& body : machine.bodies) {
    const mesh::Material& material = machine.material(body.material);
    if (body.elastic) {
      found.push_back(ratio(Kind::expansion_coefficient, body.id,
                            of_body(material.expansion, growing.count(body.id) > 0), least_material_std, 0.3));
    }
    if (material.specific_heat_table.at.empty()) {
      found.push_back(ratio(Kind::heat_capacity, body.id, of_body(material.specific_heat, storing.count(body.id) > 0),
                            least_material_std, 0.3));
    }
  }
}

/// Expansions, capacities and stiffnesses.
void add_parts(const Machine& machine, const Measurement& measurement, std::vector<Parameter>& found) {
  add_materials(machine, found);
  for (const mesh::VolumeSpec& volume : machine.volumes) {
    if (balances(volume, measurement))
      found.push_back(ratio(Kind::volume_capacity, volume.id, volume.capacity, least_material_std, 0.5));
  }
  for (const mesh::ScaleSpec& scale : machine.scales)
    found.push_back(ratio(Kind::scale_expansion, scale.axis, scale.expansion, least_material_std, 0.4));
  for (const mesh::ScrewSpec& screw : machine.screws)
    found.push_back(ratio(Kind::screw_expansion, screw.axis, screw.expansion, least_material_std, 0.4));
  for (const mesh::JointSpec& joint : machine.joints) {
    if (!(joint.stiffness_normal.value > 0.0)) continue;
    // One factor for both: it is as uncertain as the less certain of them.
    core::Uncertain stated = joint.stiffness_normal;
    stated.std_percent = std::max(stated.std_percent, joint.stiffness_tangential.std_percent);
    found.push_back(ratio(Kind::contact_stiffness, joint.id, stated, least_stiffness_std, 0.8));
  }
}

/// Mean time between the values of the sparsest input that switches, less that between rows where each change has a
/// time of its own, s.
double input_spacing(const Measurement& measurement, bool each_change_told) {
  if (measurement.data.rows() < 2) return 0.0;
  const Eigen::VectorXd time = measurement.time();
  const double duration = time[time.size() - 1] - time[0];
  double sparsest = 0.0;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.input.empty() || channel.kind == ChannelKind::temperature ||
        compensation::channel_named(channel.input).quantity == compensation::Quantity::range)
      continue;
    const double values = measurement.values(channel).array().isFinite().count();
    // A channel that is given once and stands is no clock.
    if (values >= 0.3 * time.size()) sparsest = std::max(sparsest, duration / values);
  }
  return each_change_told ? std::max(0.0, sparsest - duration / time.size()) : sparsest;
}

/// Stated uncertainties of clocks and lags, s. A missing value repeats the last one, so what follows it seems early by
/// half the time between values. In rows without one at each change, all changes may come late by a part of a row, all
/// alike: that is no clock's fault, and three deviations of a clock are a row. Nor is it a sensor's, which lags beside
/// others that seem early.
struct Times {
  double clock, lag;
};
Times time_spread(const Measurement& measurement, double told_row_s) {
  const double spacing = input_spacing(measurement, told_row_s > 0.0 || measurement.rows_at_changes);
  const double open = 0.5 * spacing + clock_share_of_row * told_row_s;
  return {std::max(clock_std_s, open), std::max(lag_std_s, open)};
}

void add_readings(const Machine& machine, const Measurement& measurement, double told_row_s,
                  std::vector<Parameter>& found) {
  std::set<std::string> seen;  // a sensor that two channels read is offered once
  int temperatures = 0, displacements = 0;
  std::map<std::string, std::vector<const MeasuredChannel*>> alike;  // by quantity
  const auto [clock_std, lag_std] = time_spread(measurement, told_row_s);
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind == ChannelKind::displacement) {
      ++displacements;
      found.push_back(
          candidate(Kind::probe_drift, channel.id, std::max(drift_std_um_h, 0.05 * channel.uncertainty), 1.5));
      if (channel.unit == "um/m") found.back().unit = "um/m/h";
      alike[channel.quantity].push_back(&channel);
    } else if (channel.kind == ChannelKind::temperature && machine.sensor_index(channel.sensor) >= 0 &&
               seen.insert(channel.sensor).second) {
      ++temperatures;
      const double noise = std::max(channel.uncertainty, 0.01);
      found.push_back(candidate(Kind::sensor_offset, channel.id, noise, 2.0));
      found.push_back(candidate(Kind::sensor_drift, channel.id, std::max(drift_std_K_h, 0.02 * noise), 0.06));
      found.push_back(candidate(Kind::sensor_lag, channel.id, lag_std, 1200.0));
      if (machine.ambient_index("air") >= 0)
        found.push_back(candidate(Kind::sensor_detached, channel.id, detached_std, 0.6));
      for (std::size_t back = machine.ambient_index("air") >= 0 ? 4 : 3; back > 0; --back)
        found[found.size() - back].item = channel.sensor;
    } else {
      continue;
    }
    found.push_back(candidate(Kind::clock_shift, channel.id, clock_std, 1800.0));
  }
  // A fixture that creeps, a tool or wheel that wears: all displacements of a quantity drift alike.
  for (const auto& [quantity, channels] : alike) {
    if (channels.size() < 2) continue;
    const MeasuredChannel& first = *channels.front();
    found.push_back(candidate(Kind::probe_drift, "displacement." + quantity,
                              std::max(drift_std_um_h, 0.05 * first.uncertainty), 1.5));
    if (first.unit == "um/m") found.back().unit = "um/m/h";
  }
  // The clock of a whole device, where it has more than one channel.
  if (temperatures > 1) found.push_back(candidate(Kind::clock_shift, "temperature", clock_std, 1800.0));
  if (displacements > 1) found.push_back(candidate(Kind::clock_shift, "displacement", clock_std, 1800.0));
}

}  // namespace

std::vector<Parameter> candidate_parameters(const Machine& machine, const Measurement& measurement, bool with_parts,
                                            double told_row_s) {
  std::vector<Parameter> found;
  add_sources(machine, measurement, found);
  add_films(machine, found);
  for (const mesh::JointSpec& joint : machine.joints) {
    if (joint.conductance.value > 0.0)
      found.push_back(ratio(Kind::contact_conductance, joint.id, joint.conductance, least_contact_std, 0.8));
    if (joint.conductance.value > 0.0 && joint.law.pressure.value > 0.0)
      found.push_back(ratio(Kind::contact_pressure, joint.id, joint.law.pressure, least_pressure_std, 0.6));
  }
  add_ambients(machine, measurement, found);
  add_coolants(machine, measurement, found);
  add_volumes(machine, measurement, found);
  if (with_parts) add_parts(machine, measurement, found);
  add_readings(machine, measurement, told_row_s, found);
  return found;
}

std::vector<const mesh::SourceSpec*> unrecorded_sources(const Machine& machine, const Measurement& measurement) {
  std::vector<const mesh::SourceSpec*> found;
  for (const mesh::SourceSpec& source : machine.sources)
    if (is_process(machine, source) && !measures(measurement, source.drive + ".power_W")) found.push_back(&source);
  return found;
}

}  // namespace thermotwin::diagnosis
