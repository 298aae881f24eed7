// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/loss_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::solver {

namespace {

constexpr double pi = std::numbers::pi;

/// Integral of |sin + f| from 0 to x, f from 0 to 1.
double integral_of_torque(double x, double f) {
  const double alpha = std::asin(f), periods = std::floor(x / (2.0 * pi)), y = x - 2.0 * pi * periods;
  // sin + f is negative from pi + alpha to 2 pi - alpha only.
  const auto negative = [&](double to) { return std::cos(to) + std::cos(alpha) - f * (to - pi - alpha); };
  const double last = 2.0 * pi - alpha, of_this = y > pi + alpha ? negative(std::min(y, last)) : 0.0;
  return 1.0 - std::cos(x) + f * x + 2.0 * (periods * negative(last) + of_this);
}

struct Torque {
  double magnitude, square;  ///< means over a range; 1: of the largest moment
};

/// Of sin + f. @param a, b  angles from the one at which the mass hangs
Torque torque_over(double a, double b, double f) {
  if (!(b - a > 1e-9)) {
    const double at = std::abs(std::sin(a) + f);
    return {at, at * at};
  }
  return {(integral_of_torque(b, f) - integral_of_torque(a, f)) / (b - a),
          0.5 - std::cos(a + b) * std::sin(b - a) / (2.0 * (b - a)) +
              f * (f + 2.0 * (std::cos(a) - std::cos(b)) / (b - a))};
}

/// Where sin^2 is largest within [low, high].
double steepest(double low, double high, double balanced) {
  const double first = balanced + pi * (std::ceil((low - balanced) / pi - 0.5) + 0.5);
  if (first <= high) return first;
  return std::abs(std::sin(low - balanced)) > std::abs(std::sin(high - balanced)) ? low : high;
}

}  // namespace

double bearing_torque(const mesh::BearingLoss& bearing, double turns_per_s) {
  const double rpm = std::abs(turns_per_s) * 60.0;
  const double dm = bearing.mean_diameter * 1e3, viscosity = bearing.viscosity * 1e6;  // mm, mm^2/s
  const double of_speed = std::max(160.0, std::pow(viscosity * rpm, 2.0 / 3.0));
  const double free_torque = 1e-7 * bearing.f0 * of_speed * dm * dm * dm, load_torque = bearing.f1 * bearing.load * dm;
  return bearing.count * (free_torque + load_torque) * 1e-3;
}

double loss_power(const mesh::BearingLoss& bearing, double turns_per_s) {
  return bearing_torque(bearing, turns_per_s) * 2.0 * pi * std::abs(turns_per_s);
}

double loss_power(const mesh::GuideLoss& guide, double speed) {
  return (guide.coulomb + guide.viscous * std::abs(speed)) * std::abs(speed);
}

double loss_power(const mesh::ScrewLoss& screw, double speed) {
  const double drag = 0.05 / std::sqrt(screw.lead / (pi * screw.diameter));
  return (drag * screw.preload + screw.load * (1.0 - screw.efficiency) / screw.efficiency) * std::abs(speed);
}

double loss_power(const mesh::MotorLoss& motor, double turns_per_s, double on) {
  const double n = std::abs(turns_per_s), relative = n / motor.nominal_speed;
  double power = motor.hysteresis * relative + motor.eddy * relative * relative;
  if (motor.torque_constant > 0.0) {
    const double current = motor.torque(n) / motor.torque_constant;
    power += on * motor.phases * motor.resistance * mesh::copper_factor(motor.winding_C) * current * current;
  }
  return power;
}

double loss_power(const mesh::HoldingLoss& holding, double low, double high, double positive) {
  if (high < low) std::swap(low, high);
  const double a = low - holding.balanced, b = high - holding.balanced;
  const auto power = [&](const Torque& torque) {
    return holding.full_power *
           (holding.linear_share * torque.magnitude + (1.0 - holding.linear_share) * torque.square);
  };
  const double after_positive = power(torque_over(a, b, holding.friction));
  if (!(holding.friction > 0.0)) return after_positive;
  // |sin(x) - f| is |sin(x + pi) + f|.
  return positive * after_positive + (1.0 - positive) * power(torque_over(a + pi, b + pi, holding.friction));
}

LossInput::LossInput(const mesh::Machine& machine, const Channels& channels, const mesh::LossLaw& loss) {
  on_ = channels.index("machine.on");
  if (loss.motion == "spindle") {
    speed_ = channels.index("spindle.speed_rpm");
    to_speed_ = loss.turns / core::units::minute;
    fastest_ = machine.spindle_max_rpm;
    return;
  }
  axis_ = machine.axis_index(loss.motion);
  if (axis_ < 0) throw core::InputError("law", "motion '" + loss.motion + "'", "\"spindle\" or the id of an axis");
  const mesh::Axis& axis = machine.axes[axis_];
  const bool linear = axis.kind == mesh::AxisKind::linear;
  const AxisChannels& of_axis = channels.of_axis(axis_);
  position_ = of_axis.position;
  speed_ = of_axis.feed;
  low_ = of_axis.low;
  high_ = of_axis.high;
  clamped_ = of_axis.clamped;
  positive_ = of_axis.positive;
  to_position_ = of_axis.unit;
  fastest_ = axis.rapid * core::units::minute / to_position_;
  const bool by_speed =
      std::holds_alternative<mesh::GuideLoss>(loss.law) || std::holds_alternative<mesh::ScrewLoss>(loss.law);
  to_speed_ = (by_speed ? core::units::mm
               : linear ? loss.turns * core::units::mm
                        : loss.turns / 360.0) /
              core::units::minute;
}

double LossInput::power(const mesh::LossLaw& loss, const Eigen::VectorXd& row) const {
  const double speed = row[speed_] * to_speed_;
  // A speed that nobody gives: its law has nothing to say.
  if (const auto* holding = std::get_if<mesh::HoldingLoss>(&loss.law)) {
    double low = row[low_], high = row[high_];
    if (!std::isfinite(low) || !std::isfinite(high)) low = high = row[position_];
    if (!std::isfinite(low)) return 0.0;
    const double positive = positive_ < 0 ? either_direction : row[positive_];
    return row[on_] * (1.0 - row[clamped_]) * loss_power(*holding, low * to_position_, high * to_position_, positive);
  }
  if (!std::isfinite(speed)) return 0.0;
  if (const auto* motor = std::get_if<mesh::MotorLoss>(&loss.law)) return loss_power(*motor, speed, row[on_]);
  if (const auto* bearing = std::get_if<mesh::BearingLoss>(&loss.law)) return loss_power(*bearing, speed);
  if (const auto* guide = std::get_if<mesh::GuideLoss>(&loss.law)) return loss_power(*guide, speed);
  return loss_power(std::get<mesh::ScrewLoss>(loss.law), speed);
}

void LossInput::set_hottest(const mesh::LossLaw& loss, const mesh::Machine& machine, Eigen::VectorXd& row) const {
  row[on_] = 1.0;
  if (const auto* holding = std::get_if<mesh::HoldingLoss>(&loss.law)) {
    const mesh::Axis& axis = machine.axes[axis_];
    const double angle = steepest(axis.low, axis.high, holding->balanced);
    row[position_] = angle / to_position_;
    row[low_] = row[high_] = not_given;
    row[clamped_] = 0.0;
    if (positive_ >= 0) row[positive_] = std::sin(angle - holding->balanced) < 0.0 ? 0.0 : 1.0;
    return;
  }
  // Motors may have their largest torque at any speed.
  double best = -1.0, speed = fastest_;
  constexpr int tries = 40;
  for (int i = 0; i <= tries; ++i) {
    row[speed_] = fastest_ * i / tries;
    if (const double now = power(loss, row); now > best) {
      best = now;
      speed = row[speed_];
    }
  }
  row[speed_] = speed;
}

}  // namespace thermotwin::solver
