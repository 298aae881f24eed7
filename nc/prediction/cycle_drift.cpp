// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/prediction/cycle_drift.h"

#include <Eigen/LU>

#include <cmath>

#include "solver/operation/chiller.h"

namespace thermotwin::nc {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void CycleDrift::Sums::add(double seconds, const Sums& rates) {
  time += seconds;
  row += seconds * rates.row;
  p += seconds * rates.p;
  state += seconds * rates.state;
}

/// f at the mean row of a period, with the mean of p over it.
struct CycleDrift::Balance {
  const reduction::ReducedSystem& system;
  const solver::OperatingModel& operating;
  VectorXd row, p_offset;

  VectorXd readings(const VectorXd& state) const { return system.sensors * state; }
  solver::Coefficients coefficients(const VectorXd& readings_K) const {
    const VectorXd inlet =
        solver::chiller_set_points(operating.machine(), operating.layout(), readings_K, operating.guide_K(row));
    solver::Coefficients coefficients = operating.coefficients(row, inlet, readings_K);
    if (p_offset.size() > 0) coefficients.p += p_offset;
    return coefficients;
  }
  MatrixXd operator_at(const VectorXd& p) const {
    MatrixXd matrix = system.conduction;
    for (Eigen::Index j = 0; const MatrixXd& term : system.terms) matrix += p[j++] * term;
    return matrix;
  }
  VectorXd flow(const VectorXd& readings_K, const VectorXd& state) const {
    const solver::Coefficients c = coefficients(readings_K);
    return system.inputs * c.q - operator_at(c.p) * state;
  }
  /// -df/dm
  MatrixXd slope(const VectorXd& state) const {
    const VectorXd at = readings(state);
    const solver::Coefficients here = coefficients(at);
    MatrixXd slope = operator_at(here.p);
    constexpr double step_K = 0.01;
    for (Eigen::Index r = 0; r < at.size(); ++r) {
      VectorXd moved = at;
      moved[r] += step_K;
      const solver::Coefficients there = coefficients(moved);
      if (there.p == here.p && there.q == here.q) continue;
      const VectorXd flow = system.inputs * (there.q - here.q) - (operator_at(there.p) - operator_at(here.p)) * state;
      slope -= flow / step_K * system.sensors.row(r);
    }
    return slope;
  }
};

CycleDrift::CycleDrift(const reduction::ReducedModel& model)
    : model_(model),
      operating_(model.machine, model.system.layout),
      defaults_(operating_.channels().defaults()) {
  sums_.row = VectorXd::Zero(defaults_.size());
  sums_.p = VectorXd::Zero(std::ssize(model.system.terms));
  sums_.state = VectorXd::Zero(model.system.order());
}

void CycleDrift::row(double duration, const VectorXd& row, const VectorXd& before, const VectorXd& after) {
  if (duration_ > 0.0) sums_.add(duration_, rates_);
  duration_ = duration;
  before_ = before;
  after_ = after;
  rates_.row = row;
  for (Eigen::Index i = 0; i < row.size(); ++i)
    if (std::isnan(row[i])) rates_.row[i] = defaults_[i];
  const Balance balance{model_.system, operating_, rates_.row, {}};
  rates_.p = balance.coefficients(balance.readings(after)).p;
  rates_.state = after;  // steps are implicit
}

void CycleDrift::begin_period(double share) {
  first_ = std::move(last_);
  last_ = Mark{sums_, before_ + share * (after_ - before_)};
  last_->sums.add(share * duration_, rates_);
}

std::optional<VectorXd> CycleDrift::ahead() const {
  if (!first_ || !last_) return std::nullopt;
  const double period = last_->sums.time - first_->sums.time;
  if (!(period > 0.0)) return std::nullopt;
  const auto mean = [&](VectorXd Sums::*of) { return VectorXd((last_->sums.*of - first_->sums.*of) / period); };
  const VectorXd state = mean(&Sums::state);
  Balance balance{model_.system, operating_, mean(&Sums::row), {}};
  balance.p_offset = mean(&Sums::p) - balance.coefficients(balance.readings(state)).p;
  // What the mean row leaves out counts as constant.
  const VectorXd rest =
      model_.system.capacity * (last_->state - first_->state) / period - balance.flow(balance.readings(state), state);
  VectorXd there = state;
  constexpr int most = 20;
  constexpr double close = 1e-7;
  for (int i = 0; i < most; ++i) {
    const VectorXd change =
        balance.slope(there).partialPivLu().solve(rest + balance.flow(balance.readings(there), there));
    if (!change.allFinite()) return std::nullopt;
    there += change;
    if (change.norm() <= close * (1e-6 + there.norm())) return there - state;
  }
  return std::nullopt;
}

}  // namespace thermotwin::nc
