// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of losses (the kinds of [[source]] law) and of contact conductances from machine.toml.

#include "mesh/machine/loss_file.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "mesh/machine/reader.h"

namespace thermotwin::mesh {

namespace reader {

using core::InputError;
using core::Node;

namespace {

constexpr double gravity = 9.80665;  // m/s^2
constexpr double megapascal = 1e6;

const Axis* find_axis(const Draft& draft, const std::string& id) {
  const int index = draft.machine.axis_index(id);
  return index < 0 ? nullptr : &draft.machine.axes[index];
}

/// The axis that the law names, of one kind. Axes are read before sources.
const Axis& require_axis(const Node& node, const Draft& draft, const std::string& id, AxisKind kind) {
  const Axis* axis = find_axis(draft, id);
  if (axis && axis->kind == kind) return *axis;
  std::vector<std::string> allowed;
  for (const Axis& other : draft.machine.axes)
    if (other.kind == kind) allowed.push_back(other.id);
  throw InputError(node.place("motion"), "'" + id + "'",
                   std::string("the id of a ") + (kind == AxisKind::linear ? "linear" : "rotary") +
                       " axis: " + (allowed.empty() ? "there is none" : core::join(allowed)));
}

/// Turns of a turning part: per turn of what moves it, or per metre of a linear axis.
double read_turns(const Node& node, const Draft& draft, const std::string& motion) {
  const double ratio = node.number("ratio");
  if (motion == "spindle") {
    refuse(node, "pitch_mm", "pitch_mm belongs to a linear axis");
    return ratio;
  }
  const Axis* axis = find_axis(draft, motion);
  if (axis == nullptr) {
    std::vector<std::string> allowed = {"spindle"};
    for (const Axis& other : draft.machine.axes) allowed.push_back(other.id);
    throw InputError(node.place("motion"), "'" + motion + "'", "one of: " + core::join(allowed));
  }
  if (axis->kind == AxisKind::rotary) {
    refuse(node, "pitch_mm", "pitch_mm belongs to a linear axis");
    return ratio;
  }
  return ratio / (node.number("pitch_mm") * millimetre);
}

Curve read_curve(const Node& node, const std::string& at_key, const std::string& value_key, double at_unit) {
  Curve curve{node.numbers(at_key), node.numbers(value_key)};
  if (curve.at.empty() || curve.at.size() != curve.value.size()) {
    throw InputError(node.place(value_key), fmt::format("{} numbers for {}", curve.value.size(), curve.at.size()),
                     "as many numbers in " + value_key + " as in " + at_key + ", one or more");
  }
  for (std::size_t i = 0; i < curve.at.size(); ++i) {
    if (i > 0 && !(curve.at[i] > curve.at[i - 1]))
      throw InputError(node.place(at_key), fmt::format("{} after {}", curve.at[i], curve.at[i - 1]), "rising numbers");
  }
  for (double& at : curve.at) at *= at_unit;
  return curve;
}

BearingLoss read_bearing(const Node& node) {
  BearingLoss loss;
  loss.f0 = node.number("f0");
  loss.f1 = node.number("f1");
  loss.mean_diameter = node.number("mean_diameter_mm") * millimetre;
  loss.viscosity = node.number("viscosity_mm2_s") * 1e-6;
  loss.load = node.number("load_N");
  loss.count = node.integer("count");
  return loss;
}

GuideLoss read_guide(const Node& node) {
  GuideLoss loss;
  loss.coulomb = node.number("coulomb_N");
  loss.viscous = node.number("viscous_N_s_m");
  if (loss.coulomb == 0.0 && loss.viscous == 0.0)
    throw InputError(node.place(), "a guide without friction", "coulomb_N, viscous_N_s_m or both");
  return loss;
}

ScrewLoss read_ball_screw(const Node& node) {
  ScrewLoss loss;
  loss.lead = node.number("pitch_mm", core::Range{0.1, 1000.0}) * millimetre;
  loss.diameter = node.number("mean_diameter_mm", core::Range{0.5, 1000.0}) * millimetre;
  loss.preload = node.number("preload_N");
  loss.load = node.number("load_N");
  loss.efficiency = node.number("efficiency");
  return loss;
}

MotorLoss read_motor(const Node& node) {
  MotorLoss loss;
  if (node.has("at_rpm")) {
    loss.torque = read_curve(node, "at_rpm", "torque_Nm", 1.0 / 60.0);
  } else {
    loss.torque = {{0.0}, {node.number("torque_Nm")}};
  }
  const bool turns_current = *std::max_element(loss.torque.value.begin(), loss.torque.value.end()) > 0.0;
  if (turns_current) {
    loss.torque_constant = node.number("torque_constant_Nm_A");
    loss.resistance = node.number("resistance_ohm");
  } else {
    for (const char* key : {"torque_constant_Nm_A", "resistance_ohm"})
      refuse(node, key, "together with torque_Nm above 0");
  }
  loss.phases = node.integer("phases");
  loss.winding_C = node.number("winding_C");
  loss.hysteresis = node.number("hysteresis_W");
  loss.eddy = node.number("eddy_W");
  if (loss.hysteresis > 0.0 || loss.eddy > 0.0)
    loss.nominal_speed = node.number("nominal_rpm") / 60.0;
  else
    refuse(node, "nominal_rpm", "together with hysteresis_W or eddy_W");
  if (!turns_current && loss.hysteresis == 0.0 && loss.eddy == 0.0)
    throw InputError(node.place(), "a motor without losses", "torque_Nm, hysteresis_W or eddy_W");
  return loss;
}

HoldingLoss read_holding(const Node& node, const Axis& axis) {
  HoldingLoss loss;
  const double across = axis.direction.cross(Eigen::Vector3d::UnitZ()).norm();  // gravity's share about the axis
  if (across < 1e-3) {
    throw InputError(node.place("motion"), "the vertical axis '" + axis.id + "'",
                     "an axis about which gravity has a lever arm");
  }
  loss.balanced = node.number("balanced_at_deg") * degree;
  loss.friction = node.number("friction_share");
  if (node.has("full_power_W")) {
    for (const char* key : {"mass_kg", "lever_mm", "torque_constant_Nm_A", "resistance_ohm", "phases", "winding_C"})
      refuse(node, key, "either full_power_W or the motor's data");
    loss.full_power = node.number("full_power_W");
    loss.linear_share = node.number("linear_share");
  } else {
    refuse(node, "linear_share", "together with full_power_W");
    const double moment = node.number("mass_kg") * gravity * node.number("lever_mm") * millimetre * across;
    const double current = moment / node.number("torque_constant_Nm_A");
    const double warm = copper_factor(node.number("winding_C"));
    loss.full_power = node.integer("phases") * node.number("resistance_ohm") * warm * current * current;
  }
  return loss;
}

}  // namespace

LossLaw read_loss(const Node& node, const Draft& draft) {
  LossLaw loss;
  const std::string kind = node.choice("kind");
  loss.motion = node.text("motion");
  if (kind == "bearing" || kind == "motor") {
    loss.turns = read_turns(node, draft, loss.motion);
    if (kind == "bearing")
      loss.law = read_bearing(node);
    else
      loss.law = read_motor(node);
  } else if (kind == "holding") {
    loss.law = read_holding(node, require_axis(node, draft, loss.motion, AxisKind::rotary));
  } else {
    require_axis(node, draft, loss.motion, AxisKind::linear);
    if (kind == "guide")
      loss.law = read_guide(node);
    else
      loss.law = read_ball_screw(node);
  }
  node.finish();
  return loss;
}

ContactLaw read_contact_law(const Node& node, const std::string& axis) {
  ContactLaw law;
  if (node.has("temperature_at_C"))
    law.by_temperature = read_curve(node, "temperature_at_C", "temperature_factor", 1.0);
  else
    refuse(node, "temperature_factor", "together with temperature_at_C");
  if (!node.has("pressure_MPa")) {
    for (const char* key :
         {"nominal_pressure_MPa", "clamped_pressure_MPa", "pressure_exponent", "pressure_at_MPa", "pressure_factor"})
      refuse(node, key, "together with pressure_MPa");
    return law;
  }
  law.pressure = scaled(node.uncertain("pressure_MPa"), megapascal);
  if (node.has("clamped_pressure_MPa")) {
    if (axis.empty()) refuse(node, "clamped_pressure_MPa", "a joint with axis: channel axis.<id>.clamp.on");
    law.clamped_pressure = node.number("clamped_pressure_MPa") * megapascal;
  }
  if (node.has("pressure_at_MPa")) {
    for (const char* key : {"nominal_pressure_MPa", "pressure_exponent"})
      refuse(node, key, "either a table or an exponent");
    law.by_pressure = read_curve(node, "pressure_at_MPa", "pressure_factor", megapascal);
  } else {
    refuse(node, "pressure_factor", "together with pressure_at_MPa");
    if (!node.has("nominal_pressure_MPa")) {
      throw InputError(node.place("pressure_MPa"), "a pressure without a law",
                       "nominal_pressure_MPa, the pressure at which the conductance holds, or a table pressure_at_MPa "
                       "with pressure_factor beside it");
    }
    law.nominal_pressure = node.number("nominal_pressure_MPa") * megapascal;
    law.exponent = node.number("pressure_exponent");
  }
  for (const bool clamped : {false, true}) {
    if (const double factor = law.factor(clamped); !(factor >= 1e-4 && factor <= 1e4)) {
      throw InputError(node.place(clamped ? "clamped_pressure_MPa" : "pressure_MPa"),
                       fmt::format("a conductance {:.3g} times that at the nominal pressure", factor),
                       "factors from 1e-4 to 1e4");
    }
  }
  return law;
}

}  // namespace reader

}  // namespace thermotwin::mesh
