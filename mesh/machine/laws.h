// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Laws of a machine's losses and contacts as plain data in SI units, as machine.toml states them. The equations of the
// losses and their sources are in solver/operation/loss_laws.h. The conductance of a contact rises with a power of the
// pressure, 0.95 after Cooper, Mikic and Yovanovich (1969).

#include <string>
#include <variant>
#include <vector>

#include "core/uncertain.h"

namespace thermotwin::mesh {

/// A function that is linear between its points and constant beyond them; without points it is 1.
struct Curve {
  std::vector<double> at, value;  ///< at rises
  double operator()(double x) const;
};

/// The channel of the time of day, h. It may run on beyond 24 h from midnight to midnight; tables over it repeat daily.
inline constexpr const char* time_of_day = "day.time_h";

enum class TableInput { value, magnitude, hour };  ///< as the exported C has them
/// @return what a table over a channel takes of it: temperatures as they are, the time of day modulo 24 h, and the
///   absolute value of all others
TableInput table_input(const std::string& channel);
double at_input(TableInput input, double value);

/// @return the resistance of copper relative to that at 20 degC (IEC 60034-1)
inline double copper_factor(double winding_C) { return (235.0 + winding_C) / 255.0; }

struct BearingLoss {
  double f0 = 0, f1 = 0;     ///< factors of the type and lubrication, and of the load
  double mean_diameter = 0;  ///< m, of the rolling elements' centres
  double viscosity = 0;      ///< m^2/s, kinematic, of the lubricant at its temperature
  double load = 0;           ///< N, the load that determines the friction (in a spindle the preload)
  double count = 1;          ///< bearings of this kind
};
struct GuideLoss {
  double coulomb = 0, viscous = 0;  ///< N; N s/m
};
struct ScrewLoss {
  double lead = 0, diameter = 0;  ///< m a turn; m, of the balls' centres
  double preload = 0, load = 0;   ///< N
  double efficiency = 1;          ///< efficiency under load
};
struct MotorLoss {
  Curve torque;                ///< N m, effective, over the motor's speed in turns a second
  double torque_constant = 0;  ///< N m/A, effective
  double resistance = 0;       ///< ohm a phase at 20 degC
  int phases = 3;
  double winding_C = 20;
  double hysteresis = 0, eddy = 0;  ///< W at nominal_speed
  double nominal_speed = 1;         ///< turns a second
};
/// A horizontal rotary axis without balance or clamp, whose motor holds moment * sin(angle - balanced).
struct HoldingLoss {
  double balanced = 0;      ///< rad, the angle without a moment; with friction, that at which the mass hangs
  double full_power = 0;    ///< W with the lever arm horizontal
  double linear_share = 0;  ///< share of full_power proportional to the torque; the rest goes with its square
  double friction = 0;      ///< torque of friction over the largest moment: its sign is that of the last motion
};

/// One loss of a source. Its part turns `turns` times per turn of the spindle or rotary axis, or per metre of a linear
/// axis. Guides and ball screws use the speed of the axis itself.
struct LossLaw {
  std::string motion;  ///< "spindle" or the id of an axis
  double turns = 1;
  std::variant<BearingLoss, GuideLoss, ScrewLoss, MotorLoss, HoldingLoss> law;
};

/// Factors on a joint's conductance, from pressure and temperature.
struct ContactLaw {
  core::Uncertain pressure;     ///< Pa, mean in the contact; 0: the conductance is that of the file
  double clamped_pressure = 0;  ///< Pa, while the joint's axis is clamped; 0: unchanged
  double nominal_pressure = 0;  ///< Pa, at which the conductance holds
  double exponent = 0.95;
  Curve by_pressure;     ///< factor over Pa, instead of the exponent
  Curve by_temperature;  ///< factor over degC, mean of both sides where they touch

  /// @return the factor on the conductance due to the pressure
  double factor(bool clamped) const;
};

}  // namespace thermotwin::mesh
