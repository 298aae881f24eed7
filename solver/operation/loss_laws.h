// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Heat of friction and of motors, W, from machine data. n turns a second, v m/s; signs are ignored.
// - Rolling bearings: Palmgren (1959), as in Harris, Rolling Bearing Analysis, 4th ed., (14.20)-(14.24):
//     M0 = 1e-7 f0 (nu n)^(2/3) dm^3 N mm with nu in mm^2/s, n in rpm, dm in mm; 160e-7 f0 dm^3 where
//     that is more (nu n < 2024; the printed limit 2000 leaves a step of 0.8 %), M1 = f1 P dm; P = (M0 + M1) w.
// - Guides: Coulomb force and viscous friction, P = (F + c v) v.
// - Ball screws: drag of the preloaded nut (JIS B 1192) and loss of efficiency under load,
//     M = K F0 l / (2 pi) + F l (1 - eta) / (2 pi eta), K = 0.05 tan(beta)^(-1/2), tan(beta) = l / (pi d),
//   the same when the load drives the screw, whose efficiency then is 2 - 1 / eta.
// - Motors: copper m R(T) I^2 with I = M(n) / k, while the machine is on; hysteresis ~ n, eddy ~ n^2.
// - Holding: a horizontal rotary axis that its motor holds against its unbalance, M = m g l sin(angle);
//     P = P90 ((1 - s) sin^2 + s |sin|): copper losses go with the square (s = 0), the drive power that a
//     control shows (Gebhardt 2014, Fig. 4.31: 0 W at 0 deg to 3.5 kW at 90 deg) may hold a linear share.
//     It takes the mean over a pendular range, and nothing while the axis is clamped or the machine off.
//     With friction f, sin(angle) + f after a motion in positive direction takes the place of sin(angle), and
//     sin(angle) - f after one in negative direction (ibid., the same position from two sides).
// A mean speed enters as it is: with a duty below 100 % laws that are not linear see the mean.

#include <Eigen/Core>

#include <cmath>

#include "mesh/machine/machine.h"
#include "solver/operation/channels.h"

namespace thermotwin::solver {

/// N m, at a speed in turns a second.
double bearing_torque(const mesh::BearingLoss& bearing, double turns_per_s);
double loss_power(const mesh::BearingLoss& bearing, double turns_per_s);
double loss_power(const mesh::GuideLoss& guide, double speed);
double loss_power(const mesh::ScrewLoss& screw, double speed);
/// @param on  share of the time that the machine is on
double loss_power(const mesh::MotorLoss& motor, double turns_per_s, double on);
/// @param low, high  rad, the range over which the axis spends its time evenly; equal: it stands
/// @param positive   share of the time whose last motion was in positive direction
double loss_power(const mesh::HoldingLoss& holding, double low, double high, double positive = either_direction);

/// A law with its channels.
class LossInput {
public:
  /// @throws InputError for a motion that the machine does not have
  LossInput(const mesh::Machine& machine, const Channels& channels, const mesh::LossLaw& loss);

  double power(const mesh::LossLaw& loss, const Eigen::VectorXd& row) const;
  /// Speed over the largest one; negative where the law has none.
  double relative_speed(const Eigen::VectorXd& row) const {
    return speed_ < 0 || !(fastest_ > 0.0) ? -1.0 : std::abs(row[speed_]) / fastest_;
  }
  /// Sets the row to where this law gives its most within travel and speed of the machine.
  void set_hottest(const mesh::LossLaw& loss, const mesh::Machine& machine, Eigen::VectorXd& row) const;

private:
  int on_ = -1, speed_ = -1, position_ = -1, low_ = -1, high_ = -1, clamped_ = -1, positive_ = -1;
  double to_speed_ = 1.0;     // turns a second, or m/s, of one unit of the speed's channel
  double to_position_ = 1.0;  // rad or m of one unit of the position's channel
  double fastest_ = 0.0;      // units of the speed's channel
  int axis_ = -1;             // index into machine.axes; -1: the spindle
};

}  // namespace thermotwin::solver
