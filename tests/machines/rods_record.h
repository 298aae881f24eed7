// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Records of the three rods of rods.h: from a finer network, another time step and perturbed nominal values, with
// noise; with causes of the diagnosis hidden in them.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"
#include "tests/machines/rods.h"

namespace lumped {

using diagnosis::Kind;

struct MeasureOptions {
  int cells = 17;
  double model_step = 45;  ///< s
  double hours = 36, sample_s = 120;
  double start_C = 20.4;
  std::uint64_t seed = 1;
  double spread = 0;  ///< of the stated standard deviations: perturbed nominal values
  double noise_K = 0.05, noise_um = 0.3;
  bool measure_air = true;
  double air_swing = 1;                         ///< of its course over the day; 0: steady
  std::string changing{};                       ///< source or joint whose heat or conductance is times ...
  std::function<double(double hour)> factor{};  ///< ... this in the course of the record
  std::string text = machine_text();            ///< of the machine that is measured
};

/// Inputs over time: what a shift does to the three rods.
inline void set_inputs(double hour, const solver::Channels& channels, Eigen::VectorXd& row, double air_swing = 1) {
  const auto set = [&](const char* name, double value) { row[channels.index(name)] = value; };
  const double rpm[] = {0, 6000, 6000, 0, 9000, 3000, 0, 11000, 4000, 0, 8000, 0};
  const double feed[] = {0, 0, 15000, 15000, 0, 0, 20000, 0, 12000, 0, 0, 18000};
  const auto part = static_cast<std::size_t>(hour / 3.0) % 12;
  set("spindle.speed_rpm", rpm[part]);
  set("axis.Z.feed_mm_min", feed[part]);
  set("axis.Z.position_mm", part % 4 == 1 ? 320 : 100);
  set("air.T_C", 20.5 + air_swing * (1.8 * std::sin(2 * std::numbers::pi * hour / 24.0) + 0.4 * std::sin(hour)));
}

/// What a faulty sensor, probe or clock makes of its column, in the plainest words.
inline void spoil(compensation::Measurement& m, const diagnosis::Parameter& fault, double value) {
  const Eigen::VectorXd time = m.data.values.col(0);
  Index air = -1;
  for (const auto& channel : m.channels)
    if (channel.input == "air.T_C") air = channel.column;
  for (const auto& channel : m.channels) {
    const bool group = (fault.where == "displacement" && !channel.quantity.empty()) ||
                       (fault.where == "temperature" && !channel.sensor.empty());
    if (channel.id != fault.where && !group) continue;
    auto column = m.data.values.col(channel.column);
    const Eigen::VectorXd before = column;
    for (Index i = 0; i < time.size(); ++i) {
      if (fault.kind == Kind::sensor_drift || fault.kind == Kind::probe_drift)
        column[i] += value * (time[i] - time[0]) / 3600.0;
      if (fault.kind == Kind::sensor_detached) column[i] += value * (m.data.values(i, air) - before[i]);
      if (fault.kind == Kind::sensor_lag && i > 0) {
        double y = column[i - 1];  // a hundred Euler steps a sample
        const double h = (time[i] - time[i - 1]) / 100.0;
        for (int k = 0; k < 100; ++k)
          y += h / value * (before[i - 1] + (before[i] - before[i - 1]) * (k + 0.5) / 100.0 - y);
        column[i] = y;
      }
      if (fault.kind == Kind::clock_shift) {
        const double at = std::clamp(time[i] - value, time[0], time[time.size() - 1]);
        const auto left = std::min(static_cast<Index>((at - time[0]) / (time[1] - time[0])), time.size() - 2);
        column[i] = before[left] + (before[left + 1] - before[left]) * (at - time[left]) / (time[1] - time[0]);
      }
    }
  }
}

/// A source or joint times a factor.
inline void change(const std::string& item, double factor, const mesh::Machine& machine, const solver::Layout& layout,
                   solver::Coefficients& c) {
  for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
    const solver::Input& input = layout.inputs[k];
    if (input.kind == solver::InputKind::source && machine.sources[input.item].id == item) c.q[k] *= factor;
    const solver::Term* term = input.term >= 0 ? &layout.terms[input.term] : nullptr;
    if (term && term->kind == solver::TermKind::contact && machine.joints[term->item].id == item) c.q[k] *= factor;
  }
  for (std::size_t t = 0; t < layout.terms.size(); ++t) {
    if (layout.terms[t].kind == solver::TermKind::contact && machine.joints[layout.terms[t].item].id == item)
      c.p[t] *= factor;
  }
}

/// A measurement of a machine: `faults` are what is wrong with it, by kinds of the diagnosis.
inline compensation::Measurement measure(const std::vector<std::pair<diagnosis::Parameter, double>>& faults,
                                         const MeasureOptions& options = {}) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  mesh::Machine m = mesh::parse_machine(options.text, "rods/machine.toml");
  const auto perturb = [&](core::Uncertain& u) {
    u.value *= std::max(0.2, 1.0 + options.spread * u.std_percent / 100.0 * normal(random));
  };
  for (auto& film : m.films) perturb(film.coefficient);
  for (auto& joint : m.joints) perturb(joint.conductance);
  for (auto& source : m.sources) perturb(source.scale);
  for (auto& coolant : m.coolants) {
    perturb(coolant.flow);
    for (auto& segment : coolant.segments) perturb(segment.film_coefficient);
  }
  double air_offset = 0;
  std::vector<double> sensor_fault(m.sensors.size(), 0.0);
  for (const auto& [parameter, value] : faults) {
    // The real air differs from its channel; a real sensor reads wrongly: neither is in a model file.
    if (parameter.kind == Kind::ambient_offset && parameter.where == "air")
      air_offset = value;
    else if (parameter.kind == Kind::sensor_offset)
      sensor_fault[m.sensor_index(parameter.item)] = value;
    else if (!diagnosis::acts_on_readings(parameter.kind))
      m = diagnosis::with_parameter(m, parameter, value);
  }
  const reduction::ReducedModel truth = model(m, options.cells);
  const solver::OperatingModel operating(m, truth.system.layout);
  const solver::Channels& channels = operating.channels();
  reduction::ReducedStepper stepper(truth.system);
  Eigen::VectorXd state = stepper.uniform(options.start_C - m.reference_C);
  const auto readings = [&] {
    Eigen::VectorXd values = truth.system.sensors * state;
    for (Index i = 0; i < values.size(); ++i) values[i] += m.sensors[i].offset;
    return values;
  };

  compensation::Measurement out;
  out.folder = "rods/measured";
  const auto add = [&](const std::string& id, compensation::ChannelKind kind, const std::string& unit,
                       double uncertainty) {
    compensation::MeasuredChannel c;
    c.id = id;
    c.kind = kind;
    c.unit = unit;
    c.uncertainty = uncertainty;
    c.column = std::ssize(out.channels) + 1;
    out.channels.push_back(c);
    return out.channels.size() - 1;
  };
  using compensation::ChannelKind;
  for (const auto& sensor : m.sensors)
    out.channels[add(sensor.id + "_reading", ChannelKind::temperature, "degC", options.noise_K)].sensor = sensor.id;
  std::vector<mesh::Pose> poses;
  for (const char* pose : {"Z=50", "Z=350"}) {
    for (const char* quantity : {"dx", "dz"}) {
      auto& c = out.channels[add(std::string(quantity) + "_" + (poses.size() < 2 ? "low" : "high"),
                                 ChannelKind::displacement, "um", options.noise_um)];
      c.quantity = quantity;
      c.pose_text = pose;
      c.zero = compensation::Zero::first;
      poses.push_back(mesh::parse_pose(m, pose, "test"));
    }
  }
  const std::vector<std::string> inputs = {"spindle.speed_rpm", "axis.Z.feed_mm_min", "axis.Z.position_mm", "air.T_C"};
  const char* units[] = {"rpm", "mm_min", "mm", "degC"};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (inputs[i] == "air.T_C" && !options.measure_air) continue;
    out.channels[add(inputs[i],
                     i == 3   ? ChannelKind::temperature
                     : i == 2 ? ChannelKind::position
                              : ChannelKind::speed,
                     units[i], i == 3 ? 0.05 : 0.0)]
        .input = inputs[i];
  }
  out.data.source = "data.csv";
  out.data.columns = {"time_s"};
  for (const auto& channel : out.channels) out.data.columns.push_back(channel.id);

  const auto samples = static_cast<Index>(options.hours * 3600 / options.sample_s) + 1;
  out.data.values.resize(samples, std::ssize(out.data.columns));
  Eigen::VectorXd row = channels.defaults();
  set_inputs(0, channels, row, options.air_swing);
  const Eigen::VectorXd guide0 = operating.guide_K(row).array() + air_offset;
  solver::Chiller chiller(m, operating.layout(), channels,
                          solver::chiller_set_points(m, operating.layout(), readings(), guide0));
  Eigen::VectorXd zero = Eigen::VectorXd::Zero(std::ssize(poses));
  for (Index s = 0; s < samples; ++s) {
    const double time = s * options.sample_s;
    set_inputs(time / 3600.0, channels, row, options.air_swing);
    auto values = out.data.values.row(s);
    values[0] = time;
    const Eigen::VectorXd read = readings();
    for (std::size_t c = 0; c < out.channels.size(); ++c) {
      const compensation::MeasuredChannel& channel = out.channels[c];
      double value = 0;
      if (!channel.sensor.empty()) {
        const std::size_t i = m.sensor_index(channel.sensor);
        value = m.reference_C + read[i] + sensor_fault[i] + options.noise_K * normal(random);
      } else if (!channel.quantity.empty()) {
        const auto p = c - m.sensors.size();
        const double um = 1e6 * truth.tcp(state, poses[p]).error[channel.quantity == "dx" ? 0 : 2];
        if (s == 0) zero[p] = um;
        value = um - zero[p] + options.noise_um * normal(random);
      } else {
        value = row[channels.index(channel.input)] + (channel.input == "air.T_C" ? 0.02 * normal(random) : 0.0);
      }
      values[channel.column] = value;
    }
    // The truth sees its own air, and takes its own steps to the next sample.
    const int parts = static_cast<int>(std::ceil(options.sample_s / options.model_step));
    for (int k = 0; k < parts; ++k) {
      const double step = options.sample_s / parts;
      Eigen::VectorXd real = row;
      set_inputs((time + (k + 0.5) * step) / 3600.0, channels, real, options.air_swing);
      real[channels.index("air.T_C")] += air_offset;
      const Eigen::VectorXd inlet = chiller.advance(real, readings(), operating.guide_K(real), step);
      solver::Coefficients c = operating.coefficients(real, inlet);
      if (options.factor)
        change(options.changing, options.factor((time + (k + 0.5) * step) / 3600.0), m, truth.system.layout, c);
      stepper.advance(state, c, step);
    }
  }
  for (const auto& [parameter, value] : faults) spoil(out, parameter, value);
  return out;
}

inline diagnosis::Parameter find(Kind kind, const std::string& where) {
  for (const auto& p : diagnosis::candidate_parameters(machine(), measure({}, {.hours = 0.1})))
    if (p.kind == kind && p.where == where) return p;
  throw std::logic_error("no parameter " + name_of(kind) + " of " + where);
}

}  // namespace lumped
