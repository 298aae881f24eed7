// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/chiller.h"

#include <cmath>

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd chiller_set_points(const mesh::Machine& machine, const VectorXd& sensors_K, double air_K) {
  VectorXd set(static_cast<Index>(machine.coolants.size()));
  for (std::size_t i = 0; i < machine.coolants.size(); ++i) {
    const mesh::CoolantSpec& coolant = machine.coolants[i];
    const double guide = coolant.guide_sensor.empty() ? air_K : sensors_K[machine.sensor_index(coolant.guide_sensor)];
    set[static_cast<Index>(i)] = guide + coolant.guide_offset;
  }
  return set;
}

Chiller::Chiller(const mesh::Machine& machine, const Channels& channels, VectorXd start_K)
    : reference_C_(machine.reference_C), outlet_K_(std::move(start_K)), inlet_K_(outlet_K_) {
  for (const mesh::CoolantSpec& coolant : machine.coolants)
    circuits_.push_back({channels.index("coolant." + coolant.id + ".on"), channels.index("coolant." + coolant.id + ".inlet_T_C"),
                         coolant.guide_sensor.empty() ? -1 : machine.sensor_index(coolant.guide_sensor), coolant.guide_offset,
                         coolant.time_constant, coolant.two_point, coolant.band, coolant.pull_down, coolant.drift_up});
  running_.assign(circuits_.size(), 0);
}

double Chiller::aim(std::size_t i) const {
  const Circuit& circuit = circuits_[i];
  if (!circuit.two_point) return 0.0;
  return running_[i] ? -circuit.pull_down : circuit.drift_up;
}

double Chiller::mean_over_step(std::size_t i, double set, double step_s) {
  const Circuit& circuit = circuits_[i];
  double& outlet = outlet_K_[static_cast<Index>(i)];
  double left = step_s, sum = 0.0;
  while (left > 0.0) {
    // Time to the end of the band, on an exponential towards the aim beyond it.
    const double target = set + aim(i), edge = set + (running_[i] ? -0.5 : 0.5) * circuit.band;
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

const VectorXd& Chiller::advance(const VectorXd& row, const VectorXd& sensors_K, double air_K, double step_s) {
  for (std::size_t i = 0; i < circuits_.size(); ++i) {
    const Circuit& circuit = circuits_[i];
    double &outlet = outlet_K_[static_cast<Index>(i)], &inlet = inlet_K_[static_cast<Index>(i)];
    const double set = (circuit.guide < 0 ? air_K : sensors_K[circuit.guide]) + circuit.offset;
    if (std::isfinite(row[circuit.inlet])) {
      outlet = row[circuit.inlet] - reference_C_;
    } else if (row[circuit.on] > 0.0 && circuit.two_point) {
      inlet = mean_over_step(i, set, step_s);
      continue;
    } else if (row[circuit.on] > 0.0) {
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
    double& value = outlet[static_cast<Index>(i)];
    if (std::isfinite(row[circuit.inlet])) {
      value = row[circuit.inlet] - reference_C_;
      continue;
    }
    if (!(row[circuit.on] > 0.0)) continue;
    const bool air = circuit.guide < 0;
    const double c0 = (air ? readings.air : readings.value[circuit.guide]) + circuit.offset + aim(i);
    const double c1 = air ? readings.air_slope : readings.slope[circuit.guide];
    const double c2 = air ? 0.0 : readings.curve[circuit.guide], tau = circuit.time_constant;
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
    if (!circuit.two_point || std::isfinite(row[circuit.inlet]) || !(row[circuit.on] > 0.0)) continue;
    const double guide = circuit.guide < 0 ? readings.air + s * readings.air_slope
                                           : readings.value[circuit.guide] + s * (readings.slope[circuit.guide] + s * readings.curve[circuit.guide]);
    const double off = outlet[static_cast<Index>(i)] - guide - circuit.offset;
    beyond[static_cast<Index>(i)] = (running_[i] ? -off : off) - 0.5 * circuit.band;
  }
  return beyond;
}

void Chiller::move(const VectorXd& row, const Readings& readings, double s) { outlet_K_ = inlet_K_ = outlet_after(row, readings, s); }

void Chiller::save(core::BinaryWriter& out) const {
  out.matrix(outlet_K_);
  out.text(std::string(running_.begin(), running_.end()));
}

void Chiller::load(core::BinaryReader& in) {
  outlet_K_ = inlet_K_ = in.matrix();
  const std::string running = in.text();
  running_.assign(running.begin(), running.end());
}

}  // namespace thermotwin::solver
