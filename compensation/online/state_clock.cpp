// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/state_clock.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Times differ by rounding; steps that are meant equal must be equal to reuse a factor.
double rounded(double duration) { return duration > 1e-3 ? std::round(duration * 1e6) / 1e6 : duration; }

}  // namespace

StateClock::StateClock(const reduction::ReducedModel& model, const solver::OperatingModel& operating, double step_s)
    : model_(model),
      operating_(operating),
      step_s_(step_s),
      stepper_(model.system),
      inputs_(model.machine, operating.channels()) {
  state_ = before_ = change_ = VectorXd::Zero(model.system.order());
  sensors_change_ = VectorXd::Zero(model.system.sensors.rows());
  clear_interval();
}

void StateClock::set_state(const VectorXd& state) {
  state_ = state;
  sensors_state_ = model_.system.sensors * state_;
}

void StateClock::start(double time, const VectorXd& row, const VectorXd& readings_K) {
  time_ = step_end_ = started_at_ = time;
  const VectorXd outlet =
      solver::chiller_set_points(model_.machine, model_.system.layout, readings_K, operating_.guide_K(row));
  chiller_.emplace(model_.machine, model_.system.layout, operating_.channels(), outlet);
  operating_.coefficients(row, outlet, readings_K, coefficients_);
}

void StateClock::add(const VectorXd& row, double time) {
  const double duration = time - time_;
  time_ = time;
  inputs_.add(row, duration);
}

StateClock::Step StateClock::take_step() {
  constexpr double nothing = 1e-6;  // s: no heat flows, but a step's matrix would overflow
  const double duration = inputs_.duration();
  const VectorXd& mean = inputs_.take();
  if (duration < nothing) return {mean, duration, 0, 0.0};
  const int parts = std::max(1, static_cast<int>(std::ceil(duration / step_s_ * (1.0 - 1e-9))));
  return {mean, duration, parts, rounded(duration / parts)};
}

void StateClock::advance(const VectorXd& mean, const VectorXd& readings_K, double duration) {
  const VectorXd& outlet = chiller_->advance(mean, readings_K, operating_.guide_K(mean), duration);
  operating_.coefficients(mean, outlet, readings_K, coefficients_);
  before_ = state_;
  stepper_.advance(state_, coefficients_, duration);
  change_ = state_ - before_;
  last_step_ = duration;
  sensors_change_ = -sensors_state_;
  sensors_state_.noalias() = model_.system.sensors * state_;
  sensors_change_ += sensors_state_;

  if (interval_.duration == 0.0) first_p_ = coefficients_.p;
  p_changed_ = p_changed_ || coefficients_.p != first_p_;
  interval_.duration += duration;
  interval_.p += duration * coefficients_.p;
  interval_.q += duration * coefficients_.q;
  interval_.state += (0.5 * duration) * (before_ + state_);
  operator_sum_ += duration * stepper_.operator_matrix();
  step_end_ += duration;
}

MatrixXd StateClock::operator_at(const VectorXd& p) const {
  MatrixXd matrix = model_.system.conduction;
  for (Index j = 0; j < p.size(); ++j) matrix += p[j] * model_.system.terms[j];
  return matrix;
}

ErrorModel::Interval StateClock::no_interval() const {
  ErrorModel::Interval none;
  none.p = VectorXd::Zero(std::ssize(model_.system.terms));
  none.q = VectorXd::Zero(model_.system.inputs.cols());
  none.state = VectorXd::Zero(model_.system.order());
  return none;
}

void StateClock::clear_interval() {
  interval_ = no_interval();
  operator_sum_.setZero(model_.system.order(), model_.system.order());
  p_changed_ = false;
}

const ErrorModel::Interval& StateClock::take_interval() {
  const double duration = interval_.duration;
  taken_.duration = duration;
  // Equal coefficients stay equal to the last bit, so that their factor is found again.
  if (p_changed_) {
    taken_.p = interval_.p / duration;
  } else {
    taken_.p = coefficients_.p;
  }
  taken_.q = interval_.q / duration;
  taken_.state = interval_.state / duration;
  taken_.operator_matrix = p_changed_ ? MatrixXd(operator_sum_ / duration) : stepper_.operator_matrix();
  clear_interval();
  return taken_;
}

}  // namespace thermotwin::compensation
