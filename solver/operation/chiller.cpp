// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/chiller.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solver/operation/layout.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double steps_of_lag = 8.0;
constexpr int most_steps = 4096;

double at(const VectorXd& value, const VectorXd& slope, const VectorXd& curve, int place, double s) {
  double result = value[place];
  if (slope.size() > 0) result += s * slope[place];
  if (curve.size() > 0) result += s * s * curve[place];
  return result;
}

double reading(const Chiller::Readings& readings, int place, double s) {
  return at(readings.value, readings.slope, readings.curve, place, s);
}

}  // namespace

VectorXd chiller_set_points(const mesh::Machine& machine, const Layout& layout, const VectorXd& readings_K,
                            const VectorXd& guide_K) {
  VectorXd set(std::ssize(machine.coolants));
  for (std::size_t i = 0; i < machine.coolants.size(); ++i) {
    const mesh::CoolantSpec& coolant = machine.coolants[i];
    double guide = coolant.guide_sensor.empty() ? guide_K[i] : readings_K[machine.sensor_index(coolant.guide_sensor)];
    const int warmed_by =
        reading_index(machine, layout, ObservedKind::volume, machine.volume_index(coolant.guide_warmed_by));
    if (warmed_by >= 0) guide += coolant.guide_warmed_share * (readings_K[warmed_by] - guide);
    set[i] = guide + coolant.guide_offset;
  }
  return set;
}

Chiller::Chiller(const mesh::Machine& machine, const Layout& layout, const Channels& channels, VectorXd start_K)
    : reference_C_(machine.reference_C),
      outlet_K_(std::move(start_K)),
      inlet_K_(outlet_K_),
      integral_K_(VectorXd::Zero(outlet_K_.size())) {
  for (std::size_t i = 0; i < machine.coolants.size(); ++i) {
    const mesh::CoolantSpec& coolant = machine.coolants[i];
    circuits_.push_back(
        {channels.index("coolant." + coolant.id + ".on"), channels.index("coolant." + coolant.id + ".inlet_T_C"),
         coolant.guide_sensor.empty() ? -1 : machine.sensor_index(coolant.guide_sensor),
         reading_index(machine, layout, ObservedKind::coolant_return, i),
         reading_index(machine, layout, ObservedKind::volume, machine.volume_index(coolant.guide_warmed_by)),
         coolant.guide_warmed_share, coolant.guide_offset, coolant.inlet_offset, coolant.time_constant, coolant.control,
         coolant.controls_return, coolant.band, coolant.pull_down, coolant.drift_up, coolant.gain,
         coolant.integral_time, coolant.flow.value * coolant.specific_heat, coolant.power});
  }
  running_.assign(circuits_.size(), 0);
}

bool Chiller::follows_return() const {
  return std::any_of(circuits_.begin(), circuits_.end(), [](const Circuit& circuit) { return circuit.returns >= 0; });
}

bool Chiller::exact(std::size_t i) const {
  return !circuits_[i].controls_return && circuits_[i].control != mesh::ChillerControl::pi;
}

double Chiller::set_point(std::size_t i, const Readings& readings, double s) const {
  const Circuit& circuit = circuits_[i];
  double guide =
      circuit.guide < 0 ? at(readings.guide, readings.guide_slope, {}, i, s) : reading(readings, circuit.guide, s);
  if (circuit.warmed_by >= 0) guide += circuit.warmed_share * (reading(readings, circuit.warmed_by, s) - guide);
  return guide + circuit.offset;
}

double Chiller::held(std::size_t i, const Readings& readings, double s, double outlet) const {
  return circuits_[i].controls_return ? reading(readings, circuits_[i].returns, s) : outlet;
}

/// Two-point control of the outlet in a step in which the set point stands.
double Chiller::mean_over_step(std::size_t i, double set, double step_s) {
  const Circuit& circuit = circuits_[i];
  double& outlet = outlet_K_[i];
  double left = step_s, sum = 0.0;
  while (left > 0.0) {
    // Time to the end of the band, on an exponential towards the aim beyond it.
    const double target = set + (running_[i] ? -circuit.pull_down : circuit.drift_up);
    const double edge = set + (running_[i] ? -0.5 : 0.5) * circuit.band;
    const double ratio = (edge - target) / (outlet - target);
    const double to_edge = ratio < 1.0 && ratio > 0.0 ? -circuit.time_constant * std::log(ratio) : 0.0;
    const double span = std::min(left, to_edge);
    const double decay = std::exp(-span / circuit.time_constant);
    sum += target * span + (outlet - target) * circuit.time_constant * (1.0 - decay);
    outlet = target + (outlet - target) * decay;
    left -= span;
    if (to_edge <= span && left > 0.0) running_[i] ^= 1;
  }
  return sum / step_s;
}

/// dT/dt of the outlet, and of the integral.
double Chiller::slope(std::size_t i, const VectorXd& row, const Readings& readings, double s, const Walk& walk,
                      double& integral) const {
  const Circuit& circuit = circuits_[i];
  const double returned = reading(readings, circuit.returns, s);
  integral = 0.0;
  double target = returned + (walk.running ? -circuit.pull_down : circuit.drift_up);
  if (circuit.control == mesh::ChillerControl::pi) {
    const double most = circuit.power / (circuit.heat_flow * std::max(1e-6, row[circuit.on]));
    const double off = held(i, readings, s, walk.outlet) - set_point(i, readings, s);
    const double wanted = circuit.gain * off + walk.integral, cooling = std::clamp(wanted, 0.0, most);
    integral = circuit.gain / circuit.integral_time * off;
    if ((wanted > most && integral > 0.0) || (wanted < 0.0 && integral < 0.0)) integral = 0.0;
    target = returned - cooling;
  }
  return (target - walk.outlet) / circuit.time_constant;
}

/// Heun's method in steps of the lag; compressors switch at the end of a step if they may.
void Chiller::walk(std::size_t i, const VectorXd& row, const Readings& readings, double span, bool switches,
                   Walk& walk) const {
  const Circuit& circuit = circuits_[i];
  const double quickest = circuit.control == mesh::ChillerControl::pi
                              ? std::min(circuit.time_constant / (1.0 + circuit.gain), circuit.integral_time)
                              : circuit.time_constant;
  const int steps =
      std::clamp(static_cast<int>(std::ceil(steps_of_lag * span / quickest)), switches ? 16 : 1, most_steps);
  const double h = span / steps;
  for (int k = 0; k < steps; ++k) {
    const double s = h * k;
    double integral_0, integral_1;
    const double slope_0 = slope(i, row, readings, s, walk, integral_0);
    Walk guess = walk;
    guess.outlet += h * slope_0;
    guess.integral += h * integral_0;
    const double slope_1 = slope(i, row, readings, s + h, guess, integral_1);
    const double before = walk.outlet;
    walk.outlet += 0.5 * h * (slope_0 + slope_1);
    walk.integral += 0.5 * h * (integral_0 + integral_1);
    walk.sum += 0.5 * h * (before + walk.outlet);
    if (!switches || circuit.control != mesh::ChillerControl::two_point) continue;
    const double off = held(i, readings, s + h, walk.outlet) - set_point(i, readings, s + h);
    if ((walk.running ? -off : off) >= 0.5 * circuit.band) walk.running = !walk.running;
  }
}

const VectorXd& Chiller::advance(const VectorXd& row, const Readings& readings, double step_s) {
  for (std::size_t i = 0; i < circuits_.size(); ++i) {
    const Circuit& circuit = circuits_[i];
    const Index place = i;
    double &outlet = outlet_K_[place], &inlet = inlet_K_[place];
    if (std::isfinite(row[circuit.inlet])) {
      outlet = row[circuit.inlet] + circuit.inlet_offset - reference_C_;
    } else if (!(row[circuit.on] > 0.0)) {
      // It keeps its temperature.
    } else if (!exact(i)) {
      Walk path{outlet, integral_K_[place], running_[i] != 0};
      walk(i, row, readings, step_s, true, path);
      outlet = path.outlet;
      integral_K_[place] = path.integral;
      running_[i] = path.running ? 1 : 0;
      inlet = path.sum / step_s;
      continue;
    } else if (circuit.control == mesh::ChillerControl::two_point) {
      inlet = mean_over_step(i, set_point(i, readings, 0.0), step_s);
      continue;
    } else {
      const double set = set_point(i, readings, 0.0);
      outlet = set + (outlet - set) * std::exp(-step_s / circuit.time_constant);
    }
    inlet = outlet;
  }
  return inlet_K_;
}

VectorXd Chiller::outlet_after(const VectorXd& row, const Readings& readings, double s) const {
  VectorXd outlet = outlet_K_;
  for (std::size_t i = 0; i < circuits_.size(); ++i) {
    const Circuit& circuit = circuits_[i];
    double& value = outlet[i];
    if (std::isfinite(row[circuit.inlet])) {
      value = row[circuit.inlet] + circuit.inlet_offset - reference_C_;
      continue;
    }
    if (!(row[circuit.on] > 0.0)) continue;
    if (!exact(i)) {
      Walk path{value, integral_K_[i], running_[i] != 0};
      if (s > 0.0) walk(i, row, readings, s, false, path);
      value = path.outlet;
      continue;
    }
    // The set point is a quadratic through three of its values.
    const double tau = circuit.time_constant, h = s > 0.0 ? s : 1.0;
    const double aim = circuit.control == mesh::ChillerControl::lag ? 0.0
                       : running_[i]                                ? -circuit.pull_down
                                                                    : circuit.drift_up;
    const double set_0 = set_point(i, readings, 0.0), set_m = set_point(i, readings, 0.5 * h),
                 set_1 = set_point(i, readings, h);
    const double c0 = set_0 + aim, c1 = (4.0 * set_m - 3.0 * set_0 - set_1) / h,
                 c2 = 2.0 * (set_1 - 2.0 * set_m + set_0) / (h * h);
    // Particular solution for a quadratic, plus the decay of what differs from it at the start.
    const double at_start = c0 - tau * c1 + 2.0 * tau * tau * c2;
    const double at_end = at_start + s * (c1 - 2.0 * tau * c2) + s * s * c2;
    value = at_end + (value - at_start) * std::exp(-s / tau);
  }
  return outlet;
}

VectorXd Chiller::beyond_band(const VectorXd& row, const Readings& readings, double s) const {
  const VectorXd outlet = outlet_after(row, readings, s);
  VectorXd beyond = VectorXd::Constant(outlet.size(), -1.0);
  for (std::size_t i = 0; i < circuits_.size(); ++i) {
    const Circuit& circuit = circuits_[i];
    if (circuit.control != mesh::ChillerControl::two_point || std::isfinite(row[circuit.inlet]) ||
        !(row[circuit.on] > 0.0))
      continue;
    const double off = held(i, readings, s, outlet[i]) - set_point(i, readings, s);
    beyond[i] = (running_[i] ? -off : off) - 0.5 * circuit.band;
  }
  return beyond;
}

void Chiller::move(const VectorXd& row, const Readings& readings, double s) {
  const VectorXd there = outlet_after(row, readings, s);
  for (std::size_t i = 0; i < circuits_.size(); ++i) {
    if (exact(i) || std::isfinite(row[circuits_[i].inlet]) || !(row[circuits_[i].on] > 0.0)) continue;
    const Index place = i;
    Walk path{outlet_K_[place], integral_K_[place], running_[i] != 0};
    if (s > 0.0) walk(i, row, readings, s, false, path);
    integral_K_[place] = path.integral;
  }
  outlet_K_ = inlet_K_ = there;
}

void Chiller::save(core::BinaryWriter& out) const {
  out.matrix(outlet_K_);
  out.matrix(integral_K_);
  out.text(std::string(running_.begin(), running_.end()));
}

void Chiller::load(core::BinaryReader& in) {
  outlet_K_ = inlet_K_ = in.matrix();
  integral_K_ = in.matrix();
  const std::string running = in.text();
  running_.assign(running.begin(), running.end());
}

}  // namespace thermotwin::solver
