// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The lumped five-axis machine with every law that a machine.toml may state, and random rows of its channels.

#include <cmath>
#include <string>

#include "solver/operation/operating_model.h"
#include "tests/compensation/uniform.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation::test {

inline std::string rich_document() {
  std::string text = five_axis_document();
  const auto after = [&](const std::string& line, const std::string& more) {
    text.insert(text.find(line) + line.size(), more);
  };
  after("id = \"B_bearing\"\n", "pressure_MPa = 2\nnominal_pressure_MPa = 1.5\nclamped_pressure_MPa = 6\n");
  after("id = \"foot\"\n", "temperature_at_C = [0, 20, 50]\ntemperature_factor = [0.9, 1.0, 1.3]\n");
  return text + R"(
[[door]]
id = "cabinet"
[[ambient]]
id = "hall"
default_C = 21.5
gradient_K_m = 0.6
height_mm = 500
[[ambient]]
id = "pit"
follows = "hall"
offset_K = -1.5
[[ambient]]
id = "cellar"
follows = "pit"
offset_K = -0.25
[[volume]]
id = "cabinet"
heat_capacity_J_K = 9000
[[volume.exchange]]
with = "hall"
conductance_W_K = 12
state = "door.cabinet.open"
[[volume.exchange]]
with = "tank"
conductance_W_K = 3
[[volume]]
id = "tank"
heat_capacity_J_K = 80000
[[volume.exchange]]
with = "cellar"
conductance_W_K = 20
[[film]]
id = "free"
surfaces = ["column.skin"]
ambient = "hall"
kind = "free_convection"
orientation = "up"
length_m = 0.4
of_temperature = true
emissivity = 0.8
radiation = "exact"
surroundings = "pit"
radiation_load_W_m2 = 3
[[film]]
id = "under"
surfaces = ["bed.skin"]
ambient = "cellar"
kind = "free_convection"
orientation = "down"
length_m = 0.7
delta_K = 4
emissivity = 0.5
[[film]]
id = "wet"
surfaces = ["bed.skin"]
ambient = "tank"
kind = "free_convection"
orientation = "vertical"
length_m = 0.3
of_temperature = true
[[film]]
id = "fan"
surfaces = ["spindle.skin"]
kind = "table"
input = "spindle.speed_rpm"
at = [0, 3000, 12000]
film_coefficient_W_m2K = [5, 20, 44]
speed_factor = 1.3
[[film]]
id = "ventilation"
surfaces = ["spindle.skin"]
kind = "table"
input = "day.time_h"
at = [0, 5.5, 6, 21, 24]
film_coefficient_W_m2K = [2, 2, 9, 8, 2]
[[film]]
id = "spindle_disc"
surfaces = ["spindle.skin"]
kind = "rotating_disc"
axis = "spindle"
radius_mm = 120
fraction = 0.7
emissivity = 0.9
[[coolant]]
id = "two"
flow_kg_s = 0.08
guide_ambient = "hall"
guide_offset_K = 0.7
guide_warmed_by = "cabinet"
guide_warmed_share = 0.2
control = "two_point"
band_K = 1.2
time_constant_s = 90
[[coolant.segment]]
id = "nut"
surface = "z_slide.skin"
film_coefficient_W_m2K = 250
volume_l = 0.5
[[coolant]]
id = "tight"
flow_kg_s = 0.12
guide_sensor = "T_column"
control = "pi"
gain = 3
integral_time_s = 400
cooling_power_W = 2500
time_constant_s = 60
inlet_offset_K = 0.2
[[coolant.segment]]
id = "ram"
surface = "z_slide.skin"
film_coefficient_W_m2K = 250
volume_l = 0.5
[[coolant]]
id = "back"
flow_kg_s = 0.1
guide_ambient = "pit"
control = "two_point"
controls = "return"
band_K = 0.8
time_constant_s = 45
[[coolant.segment]]
id = "motor"
surface = "x_slide.skin"
film_coefficient_W_m2K = 250
volume_l = 0.5
[[source]]
id = "losses"
scale = 1.1
standstill_W = 35
speed_exponent = 0.4
place = [ { volume = "tank", share = 0.4 }, { joint = "Y_guide", share = 0.4, slave_share = 0.5 } ]
[[source.law]]
input = "hall.T_C"
at = [10, 20, 30]
power_W = [0, 5, 30]
[[source.law]]
input = "day.time_h"
at = [0, 6, 6.5, 18, 24]
power_W = [5, 0, 80, 60, 5]
[[source.law]]
kind = "bearing"
motion = "spindle"
ratio = 1.2
f0 = 3
f1 = 0.0005
mean_diameter_mm = 90
viscosity_mm2_s = 20
load_N = 400
count = 4
[[source.law]]
kind = "guide"
motion = "Y"
coulomb_N = 80
viscous_N_s_m = 900
[[source.law]]
kind = "ball_screw"
motion = "Z"
pitch_mm = 20
mean_diameter_mm = 40
preload_N = 2500
load_N = 900
efficiency = 0.92
[[source.law]]
kind = "motor"
motion = "X"
pitch_mm = 20
torque_Nm = [3, 5]
at_rpm = [0, 3000]
torque_constant_Nm_A = 0.9
resistance_ohm = 0.6
hysteresis_W = 20
eddy_W = 30
nominal_rpm = 3000
[[source.law]]
kind = "holding"
motion = "B"
balanced_at_deg = 10
full_power_W = 700
linear_share = 0.3
friction_share = 0.2
)";
}

inline mesh::Machine rich_machine() { return mesh::parse_machine(rich_document(), "rich/machine.toml"); }

inline solver::Layout rich_layout(const mesh::Machine& machine) {
  std::vector<solver::JointGrid> grids;
  for (const mesh::JointSpec& joint : machine.joints) {
    const int axis = joint.axis.empty() ? -1 : machine.axis_index(joint.axis);
    if (axis < 0) {
      grids.push_back({-1, false, {0.0}});
    } else if (machine.axes[axis].endless) {
      grids.push_back({axis, true, {0.0, 1.5, 3.0, 4.5}});
    } else {
      const mesh::Axis& a = machine.axes[axis];
      grids.push_back({axis, false, {a.low, 0.7 * a.low + 0.3 * a.high, 0.5 * (a.low + a.high), a.high}});
    }
  }
  return solver::make_layout(machine, std::move(grids));
}

/// A row of a machine at work: speeds, ranges, states, measured temperatures, some of them missing.
inline Eigen::VectorXd random_row(const mesh::Machine& machine, const solver::Channels& channels, Uniform& number) {
  Eigen::VectorXd row = channels.defaults();
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    const std::string& name = channels.names()[k];
    if (name.ends_with(".on") || name.ends_with(".open")) row[k] = std::floor(number(0.0, 3.0)) / 2.0;
    if (name.ends_with("T_C") && number(0.0, 1.0) < 0.6) row[k] = number(12.0, 34.0);
    // Days before and after, without a random number of its own.
    if (name == mesh::time_of_day && row[channels.index("cutting_fluid.on")] > 0.0)
      row[k] = row[channels.index("spindle.speed_rpm")] / 200.0;
    if (name.ends_with("gradient_K_m")) row[k] = number(-1.0, 1.0);
    if (name == "spindle.speed_rpm") row[k] = number(-12000.0, 12000.0);
    if (name.ends_with(".power_W") && number(0.0, 1.0) < 0.4) row[k] = number(0.0, 5000.0);
  }
  for (std::size_t a = 0; a < machine.axes.size(); ++a) {
    const mesh::Axis& axis = machine.axes[a];
    const solver::AxisChannels& of = channels.of_axis(a);
    const double low = axis.endless ? -10.0 : axis.low, high = axis.endless ? 10.0 : axis.high;
    row[of.position] = number(low, high) / of.unit;
    row[of.feed] = number(0.0, 1.0) < 0.3 ? 0.0 : number(-1.0, 1.0) * axis.rapid * 60.0 / of.unit;
    if (number(0.0, 1.0) < 0.5) {
      row[of.low] = number(low, 0.5 * (low + high)) / of.unit;
      row[of.high] = number(0.5 * (low + high), high) / of.unit;
    }
  }
  return row;
}

}  // namespace thermotwin::compensation::test
