// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/action.h"

#include <fmt/format.h>

#include <cmath>

#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/missing_source.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/place.h"
#include "diagnosis/judge/residual_analysis.h"

namespace thermotwin::diagnosis {

namespace {

std::string surfaces_in_words(const std::vector<std::string>& surfaces) {
  return surfaces.empty() ? std::string() : " (" + core::join(surfaces) + ")";
}

/// Surfaces and joints that a source heats.
std::string places_of(const mesh::SourceSpec& source) {
  std::vector<std::string> names;
  for (const mesh::SourcePlace& place : source.places)
    names.push_back(!place.surface.empty() ? place.surface : !place.joint.empty() ? place.joint : place.volume);
  return surfaces_in_words(names);
}

std::string source_action(const RankedCause& cause, const mesh::Machine& machine) {
  const Parameter& p = cause.parameter;
  std::string where = p.where;
  for (const mesh::SourceSpec& source : machine.sources)
    if (source.id == p.where) where += places_of(source);
  switch (p.kind) {
    case Kind::source_speed_law:
      return fmt::format(
          "Check lubrication and preload of {}: its power changes with speed by another law than stated (exponent "
          "{:+.2g}).",
          where, cause.value);
    case Kind::standstill_power:
      return fmt::format("Check the heat of {} at standstill: it is about {:.3g} W {} than stated.", where,
                         std::abs(cause.value), cause.value < 0 ? "less" : "more");
    case Kind::process_heat:
      return fmt::format("Check the share of the cutting power that enters at {}: it is {:.2g} times the stated share.",
                         where, cause.value);
    case Kind::source_step:
      return fmt::format(
          "Ask what was done to {} (re-lubrication, a new bearing, another preload): since {} its heat is {:.2g} times "
          "the stated one.",
          where, step_in_words(p), cause.value);
    default:
      return fmt::format(
          "Check the power of {}: its heat is {:.2g} times the stated one. Measure the drive's power, and feel "
          "for friction.",
          where, cause.value);
  }
}

std::string film_action(const RankedCause& cause, const mesh::Machine& machine) {
  const Parameter& p = cause.parameter;
  std::string where = p.where;
  for (const mesh::FilmSpec& film : machine.films)
    if (film.id == p.where) where += surfaces_in_words(film.surfaces);
  if (p.kind == Kind::film_emissivity)
    return fmt::format("Check paint, polish and covers of {}: its emissivity is {:.2g} times the stated one.", where,
                       cause.value);
  if (p.kind == Kind::radiation_load)
    return fmt::format("Look for sun, a heater or a cold wall facing {}: about {} W/m2 {} there by radiation.", where,
                       core::plain_number(std::abs(cause.value), 3), cause.value < 0 ? "leave" : "arrive");
  if (p.kind == Kind::film_speed_law) {
    return fmt::format(
        "Check the air flow at {}: the speed-dependent part of the film coefficient is {:.2g} times the stated one.",
        where, cause.value);
  }
  return fmt::format(
      "Check the heat transfer at {} (draught, fan, cover, chips, fluid): its film coefficient is {:.2g} times the "
      "stated one.",
      where, cause.value);
}

std::string warmer(double kelvin) {
  return fmt::format("{:.2g} K {}", std::abs(kelvin), kelvin > 0 ? "warmer" : "colder");
}

/// One channel alone may have a clock of its own, a device of many has one.
std::string clock_action(const RankedCause& cause) {
  const std::string& where = cause.parameter.where;
  const std::string recorded =
      fmt::format("recorded {:.3g} s too {}", std::abs(cause.value), cause.value > 0 ? "late" : "early");
  const std::string last = where.substr(where.find_last_of('/') + 1);
  if (last == "temperature" || last == "displacement")
    return fmt::format("Synchronise the clocks: {} is {}.", where, recorded);
  return fmt::format(
      "Ask first whether {0} comes from another logger: it is {1}. If so, synchronise the clocks. If not, check its "
      "place and mounting: it reacts {2} than the model predicts.",
      where, recorded, cause.value > 0 ? "later" : "earlier");
}

std::string reading_action(const RankedCause& cause) {
  const Parameter& p = cause.parameter;
  switch (p.kind) {
    case Kind::sensor_offset:
      return fmt::format("Calibrate or exchange the sensor of {}: its reading is {:.2g} K too {}.", p.where,
                         std::abs(cause.value), cause.value < 0 ? "low" : "high");
    case Kind::sensor_drift:
      return fmt::format("Exchange the sensor of {}: it drifts by {:+.2g} K/h.", p.where, cause.value);
    case Kind::sensor_lag:
      return fmt::format("Check the mounting of the sensor of {} (paste, screw, cover): it lags by {:.3g} s.", p.where,
                         cause.value);
    case Kind::sensor_detached:
      return fmt::format("Fix the sensor of {} to its place: {:.0f} % of its reading is the air's temperature.",
                         p.where, 100.0 * cause.value);
    case Kind::probe_drift:
      if (const std::size_t dot = p.where.rfind("displacement."); dot != std::string::npos) {
        return fmt::format(
            "Check fixture, probe, tool and workpiece for creep or wear: all displacements {} drift by "
            "{:+.2g} {}.",
            p.where.substr(dot + std::string("displacement.").size()), cause.value, p.unit);
      }
      return fmt::format("Check fixture and probe of {}: it drifts by {:+.2g} {}.", p.where, cause.value, p.unit);
    default: return clock_action(cause);
  }
}

std::string surroundings_action(const RankedCause& cause) {
  const Parameter& p = cause.parameter;
  switch (p.kind) {
    case Kind::ambient_gradient:
      return fmt::format(
          "Measure the air at the foot and at the top of the machine: the gradient differs by {:+.2g} K/m.",
          cause.value);
    case Kind::foundation_temperature:
      return fmt::format("Measure the foundation under the mounts: it is {} than assumed.", warmer(cause.value));
    case Kind::cutting_fluid:
      return fmt::format("Measure the cutting fluid {} at its nozzle: it is {} than assumed.", p.where,
                         warmer(cause.value));
    default:
      return fmt::format("Measure the air beside the machine at several places: {} is {} there than its channel says.",
                         p.where, warmer(cause.value));
  }
}

std::string fluid_action(const RankedCause& cause) {
  const Parameter& p = cause.parameter;
  switch (p.kind) {
    case Kind::coolant_flow:
      return fmt::format("Check the flow of coolant {} (filter, pump, valves): it is {:.2g} times the stated one.",
                         p.where, cause.value);
    case Kind::coolant_coupling:
      return fmt::format(
          "Check the coolant channel {} (deposits, trapped air, share of the flow): its film coefficient is {:.2g} "
          "times the stated one.",
          p.where, cause.value);
    case Kind::coolant_inlet:
      return fmt::format("Compare the inlet sensor of coolant {} with a second one: the inlet is {} than it reads.",
                         p.where, warmer(cause.value));
    case Kind::control_sensor_offset:
      return fmt::format("Check the guide sensor and the set point of the chiller of {}: their error is {:+.2g} K.",
                         p.where, cause.value);
    case Kind::volume_exchange:
      return fmt::format(
          "Check the enclosure at {} (doors, leaks, insulation): it exchanges {:.2g} times the stated heat.", p.where,
          cause.value);
    default:
      return fmt::format("Check the content of {}: its heat capacity is {:.2g} times the stated one.", p.where,
                         cause.value);
  }
}

/// A material in all its bodies: what was ordered, or stands in the file, is to be checked, no single casting.
std::string material_action(const RankedCause& cause, const std::vector<const mesh::BodySpec*>& bodies) {
  std::vector<std::string> names;
  for (const mesh::BodySpec* body : bodies) names.push_back(body->id);
  return fmt::format("Check the data of material {} ({}): in all of them its {} is {:.2g} times the stated one.",
                     cause.parameter.where, core::join(names),
                     cause.parameter.kind == Kind::heat_capacity ? "heat capacity" : "expansion", cause.value);
}

std::string structure_action(const RankedCause& cause, const mesh::Machine& machine) {
  const Parameter& p = cause.parameter;
  if (row_of(p.kind).target == Target::body && machine.body_index(p.where) < 0) {
    const std::vector<const mesh::BodySpec*> bodies = bodies_of_material(machine, p.where);
    if (!bodies.empty()) return material_action(cause, bodies);
  }
  switch (p.kind) {
    case Kind::contact_conductance:
      return fmt::format(
          "Check the contact of {} (bolts, preload, paint, shims): its conductance is {:.2g} times the stated one.",
          p.where, cause.value);
    case Kind::contact_pressure:
      return fmt::format("Check the preload of {}: its contact pressure is {:.2g} times the stated one.", p.where,
                         cause.value);
    case Kind::contact_step:
      return fmt::format(
          "Check {} for lost preload and loose bolts: since {} its conductance is {:.2g} times the stated one.",
          p.where, step_in_words(p), cause.value);
    case Kind::contact_stiffness:
      return fmt::format("Check preload and bolts of {}: its stiffness is {:.2g} times the stated one.", p.where,
                         cause.value);
    case Kind::expansion_coefficient:
      return fmt::format("Check the material of {}: its expansion is {:.2g} times the stated one.", p.where,
                         cause.value);
    case Kind::heat_capacity:
      return fmt::format(
          "Check mass and material of {} (ribs, fillings, attached parts): its heat capacity is {:.2g} times "
          "the stated one.",
          p.where, cause.value);
    default:
      return fmt::format("Check the data sheet of the {} of axis {}: its expansion is {:.2g} times the stated one.",
                         p.kind == Kind::scale_expansion ? "scale" : "screw", p.where, cause.value);
  }
}

}  // namespace

std::string action_of(const RankedCause& cause, const reduction::ReducedModel& model) {
  const Parameter& p = cause.parameter;
  if (p.missing) {
    const std::string action =
        fmt::format("Look at {}: about {} W {} there {}.", place_in_words(p.missing->body, p.missing->centre, model),
                    core::plain_number(std::abs(cause.value), 2), cause.value < 0 ? "leave" : "enter",
                    p.missing->daily ? in_words(*p.missing->daily) + " (sun, heating, a shift, a neighbour)"
                                     : "in proportion to " + p.missing->follows);
    if (p.missing->alike.empty()) return action;
    return action + fmt::format(
                        " In this record {} changed at the same times, so each of them may be the heat source. Run "
                        "them one after another.",
                        core::join(p.missing->alike));
  }
  switch (row_of(p.kind).target) {
    case Target::source: return source_action(cause, model.machine);
    case Target::film: return film_action(cause, model.machine);
    case Target::ambient: return surroundings_action(cause);
    case Target::coolant:
    case Target::segment:
    case Target::volume:
    case Target::exchange: return fluid_action(cause);
    case Target::joint:
    case Target::body:
    case Target::scale:
    case Target::screw: return structure_action(cause, model.machine);
    case Target::sensor:
    case Target::reading: return reading_action(cause);
    case Target::nothing: break;
  }
  return "";
}

namespace {

/// A size that changes in the course of a record.
std::string law_action(const std::string& where, const mesh::Machine& machine) {
  if (machine.joint_index(where) >= 0) {
    return fmt::format("Check {} for loss of preload and hysteresis: its contact changes in the course of the record.",
                       where);
  }
  return fmt::format(
      "Record the power of {} over time: its heat changes in the course of the record. Possible reasons are lubricant "
      "that becomes thinner, re-lubrication or a brake.",
      where);
}

/// Where something unknown is seen best.
std::string unknown_action(const Diagnosis& diagnosis) {
  const auto concerned = [&](const ResidualAnalysis& one) {
    return diagnosis.unknown_in.empty() ||
           std::find(diagnosis.unknown_in.begin(), diagnosis.unknown_in.end(), one.id) != diagnosis.unknown_in.end();
  };
  const auto furthest =
      std::max_element(diagnosis.analysis.begin(), diagnosis.analysis.end(),
                       [&](const auto& a, const auto& b) { return a.ratio * concerned(a) < b.ratio * concerned(b); });
  if (furthest == diagnosis.analysis.end()) return "";
  if (furthest->ratio < 1.0) {
    return fmt::format(
        "Begin with {}: its residual comes closest to the expected one ({:.1f} times it), and no known kind of cause "
        "explains its course. A second sensor or probe beside it shows whether the machine or the reading is wrong.",
        furthest->id, furthest->ratio);
  }
  return fmt::format(
      "Begin with {}: its residual is {:.1f} times the expected one{}, and no known kind of cause explains it. A "
      "second sensor or probe beside it shows whether the machine or the reading is wrong.",
      furthest->id, furthest->ratio, furthest->follows.empty() ? "" : " and follows " + furthest->follows);
}

/// Steps that nothing else goes with.
std::string steps_action(const StepsSeen& seen) {
  const bool temperature = seen.unit == "degC" || seen.unit == "K";
  if (seen.creeps()) {
    return fmt::format(
        "Find out what settles: {}, and nothing else changes with it. Possible reasons are {}.", in_words(seen),
        temperature ? "a sensor that was mounted shortly before, the heat of its own device, or an input that is not "
                      "recorded"
                    : "a fixture, workpiece, tool or probe that was clamped shortly before, or its own warming");
  }
  const std::string with =
      seen.inputs.empty()
          ? "and no recorded state, speed, feed or power changed in the half hour before. Possible reasons are"
          : fmt::format("after a change of {}. A consequence of it that the model lacks is possible; other reasons are",
                        core::join(seen.inputs));
  return fmt::format("Find out what happened on the machine: {}, {} {}.", in_words(seen), with,
                     temperature
                         ? "a sensor or its cable that was touched, fluid that splashed on it, or a fault of its device"
                         : "a scale that slipped, a changed tool, wheel or workpiece, a collision, or a probe that was "
                           "touched");
}

}  // namespace

std::string nearest_action(const Diagnosis& diagnosis) {
  const bool elsewhere = !diagnosis.connection.empty() || !diagnosis.steps.steps.empty();
  if (diagnosis.verdict != Verdict::unexplained || diagnosis.nearest.empty() || elsewhere) return "";
  return fmt::format(
      "Then look at {}: it comes nearest of the listed causes. The fault may lie there and act in another way or at "
      "other times than the model assumes.",
      diagnosis.nearest);
}

std::string in_words(const StepsSeen& seen) {
  const std::string unit = residual_unit(seen.unit);
  const std::string which = seen.quantity.empty()
                                ? core::join(seen.channels, " and ")
                                : "all " + std::to_string(seen.channels.size()) + " displacements together",
                    most = seen.quantity.empty() ? "" : seen.quantity + " ";
  if (seen.creeps()) {
    const ReadingStep& creep = seen.steps.front();
    return fmt::format(
        "{} creep{}, {}by {:+.3g} +- {} {}, with a time constant of about {:.0f} h from the beginning of "
        "the record on",
        which, seen.channels.size() == 1 ? "s" : "", most, creep.size, core::plain_number(creep.std, 2), unit,
        creep.memory_s / core::units::hour);
  }
  std::vector<std::string> steps;
  for (const ReadingStep& step : seen.steps) {
    steps.push_back(fmt::format("by {:+.3g} +- {} {} at {:.2f} h", step.size, core::plain_number(step.std, 2), unit,
                                step.from_s / core::units::hour));
  }
  return fmt::format("{} changed suddenly{} {}{} of the record", which, most.empty() ? "" : ",", most,
                     core::join(steps, " and "));
}

std::vector<std::string> actions_of(const Diagnosis& diagnosis, const reduction::ReducedModel& model) {
  std::vector<std::string> actions;
  const bool unknown_leads =
      diagnosis.verdict == Verdict::unexplained || (diagnosis.causes.empty() && !diagnosis.ambiguous_set.empty() &&
                                                    diagnosis.ambiguous_set.front().parameter.kind == Kind::unknown);
  const bool steps = !diagnosis.steps.steps.empty();
  if (unknown_leads) actions.push_back(steps ? steps_action(diagnosis.steps) : unknown_action(diagnosis));
  if (!actions.empty() && actions.front().empty()) actions.clear();
  for (const RankedCause& cause : diagnosis.causes) actions.push_back(action_of(cause, model));
  if (!unknown_leads && steps) actions.push_back(steps_action(diagnosis.steps));
  for (const RankedCause& cause : diagnosis.ambiguous_set)
    if (cause.parameter.kind == Kind::other_law) actions.push_back(law_action(cause.parameter.where, model.machine));
  if (actions.empty() && !diagnosis.ambiguous_set.empty()) {
    const std::string first = action_of(diagnosis.ambiguous_set.front(), model);
    if (!first.empty()) actions.push_back(first);
  }
  return actions;
}

}  // namespace thermotwin::diagnosis
