// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine of three rods (base, column, head) as a network of cells, small enough for thousands of
// runs: a reduced model of any fineness from the same machine.toml. Measurements come from a finer
// network, another time step and perturbed nominal values, with noise.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/output_grid.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/layout.h"

namespace lumped {

using namespace thermotwin;
using Eigen::Index;

inline std::string machine_text() {
  return R"(# three rods
schema = 1
name = "rods"
reference_C = 20.0
spindle_max_rpm = 12000

[[material]]
id = "iron"
density_kg_m3 = 7200
specific_heat_J_kgK = 500
conductivity_W_mK = 46
expansion_1_K = 11e-6
young_GPa = 120
poisson = 0.26

[[body]]
id = "base"
material = "iron"
cad = "base.step"
element_size_mm = 90
[[body]]
id = "column"
material = "iron"
cad = "column.step"
element_size_mm = 90
parent = "base"
[[body]]
id = "head"
material = "iron"
cad = "head.step"
element_size_mm = 90
parent = "column"
axis = "Z"

[[axis]]
id = "Z"
kind = "linear"
direction = [0, 0, 1]
travel_mm = [0, 400]

[[surface]]
id = "base.skin"
body = "base"
[[surface]]
id = "base.feet"
body = "base"
[[surface]]
id = "column.skin"
body = "column"
[[surface]]
id = "column.rails"
body = "column"
[[surface]]
id = "head.skin"
body = "head"
[[surface]]
id = "head.carriages"
body = "head"
[[surface]]
id = "head.channel"
body = "head"
[[surface]]
id = "head.motor"
body = "head"
[[surface]]
id = "column.pump"
body = "column"

[[joint]]
id = "foot"
kind = "bolted"
slave = "column.skin"
master = "base.skin"
conductance_W_m2K = {value = 1200, std_percent = 10}
[[joint]]
id = "Z_guide"
kind = "guide"
slave = "head.carriages"
master = "column.rails"
axis = "Z"
conductance_W_m2K = {value = 1500, std_percent = 10}
[[joint]]
id = "mounts"
kind = "mount"
slave = "base.feet"
ambient = "foundation"
conductance_W_m2K = { value = 400, std_percent = 10 }

[[ambient]]
id = "air"
default_C = {value = 20, std_percent = 1}
[[ambient]]
id = "foundation"
follows = "air"
offset_K = -0.5

[[film]]
id = "base.film"
surfaces = ["base.skin"]
film_coefficient_W_m2K = {value = 9, std_percent = 10} # still air
[[film]]
id = "column.film"
surfaces = ["column.skin"]
film_coefficient_W_m2K = {value = 9, std_percent = 10}
[[film]]
id = "head.film"
surfaces = ["head.skin"]
kind = "free_convection"
orientation = "vertical"
emissivity = 0.9

[[coolant]]
id = "main"
flow_kg_s = {value = 0.05, std_percent = 10}
guide_sensor = "T1"
[[coolant.segment]]
id = "jacket"
surface = "head.channel"
film_coefficient_W_m2K = {value = 60, std_percent = 10}
volume_l = 0.7

[[source]]
id = "motor"
scale = {value = 1.0, std_percent = 5}
law = [
  { input = "spindle.speed_rpm", at = [0, 6000, 12000], power_W = [0, 110, 260] },  # [table]
]
place = [ { surface = "head.motor", share = 0.9 } ]
[[source]]
id = "guide_friction"
law = [ { input = "axis.Z.feed_mm_min", at = [0, 20000], power_W = [0, 120] } ]
place = [ { joint = "Z_guide", share = 1.0, slave_share = 0.4 } ]
[[source]]
id = "pump"
law = [ { input = "machine.on", at = [0, 1], power_W = [0, 40] } ]
place = [ { surface = "column.pump" } ]

[[sensor]]
id = "T1"
body = "base"
point_mm = [0, 0, 500]
[[sensor]]
id = "T2"
body = "column"
point_mm = [0, 0, 250]
[[sensor]]
id = "T3"
body = "column"
point_mm = [0, 0, 850]
offset_K = 0.1   # calibrated
[[sensor]]
id = "T4"
body = "head"
point_mm = [0, 0, 300]
[[sensor]]
id = "T5"
body = "head"
point_mm = [0, 0, 900]
[[sensor]]
id = "T6"
body = "base"
point_mm = [0, 0, 100]

[tcp]
tool_body = "head"
tool_surface = "head.motor"
tool_point_mm = [0, 0, 0]
table_body = "base"
table_surface = "base.skin"
table_point_mm = [0, 0, 0]

[workspace]
Z_mm = [0, 200, 400]
)";
}

inline mesh::Machine machine() { return mesh::parse_machine(machine_text(), "rods/machine.toml"); }

/// Sizes of a rod.
struct Rod {
  double length, section, skin;  ///< m, m^2, m^2
};
inline const std::vector<Rod> rods = {{1.0, 0.24, 2.2}, {1.2, 0.08, 1.5}, {0.6, 0.06, 0.7}};

/// @param cells  nodes a rod
inline reduction::ReducedModel model(const mesh::Machine& m, int cells) {
  const Index n = cells;
  const Index fluid = 3 * n, size = fluid + 1;
  const double rho = 7200, heat = 500, k = 46, alpha = 11e-6;
  reduction::ReducedModel result;
  result.machine = m;
  result.size = "network of " + std::to_string(cells) + " nodes a rod";
  result.full_size = size;
  reduction::ReducedSystem& s = result.system;
  std::vector<solver::JointGrid> grids(3);
  for (auto& grid : grids) grid.positions = {0.0};
  grids[1].axis = 0;
  grids[1].positions = {0.0, 0.2, 0.4};
  s.layout = solver::make_layout(m, grids);
  s.capacity.setZero(size, size);
  s.conduction.setZero(size, size);
  // Linear elements, nodes at both ends of a rod, lumped capacity.
  const auto node_share = [&](Index i) { return (i == 0 || i + 1 == n ? 0.5 : 1.0) / (cells - 1); };
  for (Index b = 0; b < 3; ++b) {
    const Rod& rod = rods[b];
    const double g = k * rod.section * (cells - 1) / rod.length;
    for (Index i = 0; i < n; ++i) {
      s.capacity(b * n + i, b * n + i) = rho * heat * rod.section * rod.length * node_share(i);
      if (i + 1 == n) continue;
      const Index a = b * n + i, c = a + 1;
      s.conduction(a, a) += g, s.conduction(c, c) += g, s.conduction(a, c) -= g, s.conduction(c, a) -= g;
    }
  }
  s.capacity(fluid, fluid) = 0.7e-3 * 815 * 1940;
  // A spot at a share of a rod's length, spread over the two nodes next to it.
  const auto spot = [&](Index rod, double share) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
    const double at = std::clamp(share * (cells - 1), 0.0, cells - 1.0);
    const auto left = std::min(static_cast<Index>(at), n - 2);
    row[rod * n + left] = 1.0 - (at - static_cast<double>(left));
    row[rod * n + left + 1] = at - static_cast<double>(left);
    return row;
  };
  const auto skin = [&](Index rod) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
    for (Index i = 0; i < n; ++i) row[rod * n + i] = rods[rod].skin * node_share(i);
    return row;
  };
  const Eigen::VectorXd wet = Eigen::VectorXd::Unit(size, fluid);
  const auto exchange = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b, double area) {
    return Eigen::MatrixXd(area * (a - b) * (a - b).transpose());
  };
  const std::vector<double> z = {0.25, 0.5, 0.75};  // where the head hangs on the column
  for (const solver::Term& term : s.layout.terms) {
    if (term.kind == solver::TermKind::film) {
      s.terms.push_back(skin(term.item).asDiagonal());
    } else if (term.kind == solver::TermKind::coolant_wall) {
      s.terms.push_back(exchange(spot(2, 0.75), wet, 0.5));
    } else if (term.kind == solver::TermKind::coolant_flow) {
      s.terms.push_back(1940.0 * wet * wet.transpose());
    } else if (term.item == 0) {
      s.terms.push_back(exchange(spot(0, 1.0), spot(1, 0.0), 0.05));
    } else if (term.item == 1) {
      s.terms.push_back(exchange(spot(2, 0.25), spot(1, z[term.part]), 0.02));
    } else {
      s.terms.push_back(0.08 * spot(0, 0.125) * spot(0, 0.125).transpose());
    }
  }
  s.inputs.setZero(size, std::ssize(s.layout.inputs));
  for (Index i = 0; i < s.inputs.cols(); ++i) {
    const solver::Input& input = s.layout.inputs[i];
    if (input.kind == solver::InputKind::source) {
      const mesh::SourcePlace& place = m.sources[input.item].places[input.place];
      if (!place.joint.empty())
        s.inputs.col(i) = place.slave_share * spot(2, 0.25) + (1 - place.slave_share) * spot(1, z[input.node]);
      else
        s.inputs.col(i) = place.surface == "head.motor" ? spot(2, 1.0) : spot(1, 0.125);
    } else if (input.kind == solver::InputKind::film_ambient) {
      s.inputs.col(i) = skin(input.item);
    } else if (input.kind == solver::InputKind::contact_ambient) {
      s.inputs.col(i) = 0.08 * spot(0, 0.125);
    } else {
      s.inputs.col(i) = 1940.0 * wet;
    }
  }
  s.sensors.resize(std::ssize(m.sensors), size);
  for (Index i = 0; i < s.sensors.rows(); ++i) {
    const mesh::SensorSpec& sensor = m.sensors[i];
    s.sensors.row(i) = spot(m.body_index(sensor.body), sensor.point.z()).transpose();
  }
  s.one_kelvin = Eigen::VectorXd::Ones(size);
  // Column up to the head, head down to the tool, base below the table; x by the head's gradient.
  for (int p = 0; p < 3; ++p) {
    result.outputs.tool_poses.push_back(Eigen::VectorXd::Constant(1, 0.2 * p));
    Eigen::MatrixXd tool = Eigen::MatrixXd::Zero(6, size);
    // The column grows up to where the head hangs: straight lines between the nodes, exactly.
    const double top = z[p];
    for (Index e = 0; e + 1 < n; ++e) {
      const double low = static_cast<double>(e) / (cells - 1), width = 1.0 / (cells - 1);
      const double part = std::clamp((top - low) / width, 0.0, 1.0);
      tool(2, n + e + 1) += alpha * rods[1].length * width * 0.5 * part * part;
      tool(2, n + e) += alpha * rods[1].length * width * (part - 0.5 * part * part);
    }
    for (Index i = 0; i < n; ++i) {
      const double share = static_cast<double>(i) / (cells - 1);
      tool(2, 2 * n + i) = -alpha * rods[2].length * node_share(i);
      tool(0, 2 * n + i) = 0.8 * alpha * rods[2].length * node_share(i) * (share - 0.4);
      tool(0, n + i) = 0.5 * alpha * rods[1].length * node_share(i) * (share - 0.5);
    }
    result.outputs.tool.push_back(tool);
  }
  result.outputs.table_poses = reduction::OutputGrid(m).table_poses();
  Eigen::MatrixXd table = Eigen::MatrixXd::Zero(6, size);
  for (Index i = 0; i < n; ++i) table(2, i) = 0.4 * alpha * node_share(i), table(0, i) = 0.1 * alpha * node_share(i);
  result.outputs.table_axis = {table};
  result.outputs.table_own = {Eigen::MatrixXd::Zero(7, size)};
  return result;
}

struct MeasureOptions {
  int cells = 17;
  double model_step = 45;  ///< s
  double hours = 36, sample_s = 120;
  double start_C = 20.4;
  std::uint64_t seed = 1;
  double spread = 0;  ///< of the stated standard deviations: perturbed nominal values
  double noise_K = 0.05, noise_um = 0.3;
  bool measure_air = true;
  double air_swing = 1;  ///< of its course over the day; 0: steady
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
      if (fault.kind == "sensor_drift" || fault.kind == "probe_drift")
        column[i] += value * (time[i] - time[0]) / 3600.0;
      if (fault.kind == "sensor_detached") column[i] += value * (m.data.values(i, air) - before[i]);
      if (fault.kind == "sensor_lag" && i > 0) {
        double y = column[i - 1];  // a hundred Euler steps a sample
        const double h = (time[i] - time[i - 1]) / 100.0;
        for (int k = 0; k < 100; ++k)
          y += h / value * (before[i - 1] + (before[i] - before[i - 1]) * (k + 0.5) / 100.0 - y);
        column[i] = y;
      }
      if (fault.kind == "clock_shift") {
        const double at = std::clamp(time[i] - value, time[0], time[time.size() - 1]);
        const auto left = std::min(static_cast<Index>((at - time[0]) / (time[1] - time[0])), time.size() - 2);
        column[i] = before[left] + (before[left + 1] - before[left]) * (at - time[left]) / (time[1] - time[0]);
      }
    }
  }
}

/// A measurement of a machine: `faults` are what is wrong with it, by kinds of the diagnosis.
inline compensation::Measurement measure(const std::vector<std::pair<diagnosis::Parameter, double>>& faults,
                                         const MeasureOptions& options = {}) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  mesh::Machine m = machine();
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
    if (parameter.kind == "ambient_offset" && parameter.where == "air")
      air_offset = value;
    else if (parameter.kind == "sensor_offset")
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
  using Kind = compensation::ChannelKind;
  for (const auto& sensor : m.sensors)
    out.channels[add(sensor.id + "_reading", Kind::temperature, "degC", options.noise_K)].sensor = sensor.id;
  std::vector<mesh::Pose> poses;
  for (const char* pose : {"Z=50", "Z=350"})
    for (const char* quantity : {"dx", "dz"}) {
      auto& c = out.channels[add(std::string(quantity) + "_" + (poses.size() < 2 ? "low" : "high"), Kind::displacement,
                                 "um", options.noise_um)];
      c.quantity = quantity;
      c.pose_text = pose;
      c.zero = compensation::Zero::first;
      poses.push_back(mesh::parse_pose(m, pose, "test"));
    }
  const std::vector<std::string> inputs = {"spindle.speed_rpm", "axis.Z.feed_mm_min", "axis.Z.position_mm", "air.T_C"};
  const char* units[] = {"rpm", "mm_min", "mm", "degC"};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (inputs[i] == "air.T_C" && !options.measure_air) continue;
    out.channels[add(inputs[i],
                     i == 3   ? Kind::temperature
                     : i == 2 ? Kind::position
                              : Kind::speed,
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
    const double time = static_cast<double>(s) * options.sample_s;
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
      stepper.advance(state, operating.coefficients(real, inlet), step);
    }
  }
  for (const auto& [parameter, value] : faults) spoil(out, parameter, value);
  return out;
}

inline diagnosis::Parameter find(const std::string& kind, const std::string& where) {
  for (const auto& p : diagnosis::candidate_parameters(machine(), measure({}, {.hours = 0.1})))
    if (p.kind == kind && p.where == where) return p;
  throw std::logic_error("no parameter " + kind + " of " + where);
}

}  // namespace lumped
