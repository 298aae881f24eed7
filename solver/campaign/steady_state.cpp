// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/steady_state.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/progress.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/chiller.h"
#include "solver/operation/layout.h"
#include "solver/thermal/direct.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int most_solutions = 200;

/// What a chiller does with its outlet.
enum class Rule { off, given, outlet_at_set, return_at_set, limited };

class SteadySolver {
public:
  SteadySolver(const ThermalSystem& thermal, const OperatingModel& model, const VectorXd& row)
      : thermal_(thermal),
        model_(model),
        machine_(model.machine()),
        row_(row),
        guide_(model.guide_K(row)),
        offsets_(sensor_offsets(machine_, thermal.layout)),
        direct_(thermal),
        coolants_(std::ssize(machine_.coolants)),
        rules_(coolants_),
        cooling_(VectorXd::Zero(coolants_)) {}

  SteadyState solve() {
    SteadyState state;
    VectorXd readings;  // none at first: laws at their nominal temperatures
    const bool follows = model_.follows_temperature() || thermal_.local != nullptr;
    double change = 0.0;
    do {
      core::check_interrupt();
      const VectorXd last = state.temperature;
      pass(state, readings);
      readings = read(state.temperature);
      ++state.passes;
      if (!follows) return finished(state);
      change = last.size() > 0 ? (state.temperature - last).cwiseAbs().maxCoeff() : 1.0;
    } while (change > iteration_K && state.passes < most_solutions);
    if (!(change <= iteration_K)) {
      throw core::SolverError(
          fmt::format("steady state: after {} solutions the temperature still changes by {:.1e} K; the machine has "
                      "no state that stands here",
                      state.passes, change));
    }
    return finished(state);
  }

private:
  VectorXd read(const VectorXd& temperature) const { return thermal_.sensors * temperature + offsets_; }

  Rule rule_of(Index i) const {
    const mesh::CoolantSpec& coolant = machine_.coolants[i];
    const Channels& channels = model_.channels();
    if (std::isfinite(row_[channels.index("coolant." + coolant.id + ".inlet_T_C")])) return Rule::given;
    if (!(on(i) > 0.0)) return Rule::off;
    return coolant.controls_return ? Rule::return_at_set : Rule::outlet_at_set;
  }
  double on(Index i) const { return row_[model_.channels().index("coolant." + machine_.coolants[i].id + ".on")]; }
  double given_inlet(Index i) const {
    const mesh::CoolantSpec& coolant = machine_.coolants[i];
    return row_[model_.channels().index("coolant." + coolant.id + ".inlet_T_C")] + coolant.inlet_offset -
           machine_.reference_C;
  }
  int returns(Index i) const { return reading_index(machine_, thermal_.layout, ObservedKind::coolant_return, i); }

  /// How little and how much a chiller can cool the return, K; none: any.
  std::pair<double, double> limits(Index i) const {
    const mesh::CoolantSpec& coolant = machine_.coolants[i];
    if (coolant.control == mesh::ChillerControl::pi)
      return {0.0, coolant.power / (coolant.flow.value * coolant.specific_heat * std::max(1e-6, on(i)))};
    if (coolant.control == mesh::ChillerControl::two_point && coolant.controls_return)
      return {-coolant.drift_up, coolant.pull_down};
    return {-HUGE_VAL, HUGE_VAL};
  }

  /// One solution for given coefficients: the machine for no inlet and for one kelvin at each, then the inlets.
  void pass(SteadyState& state, const VectorXd& readings) {
    Coefficients& c = state.coefficients;
    model_.coefficients(row_, VectorXd::Zero(coolants_), readings, c);
    MatrixXd right(thermal_.size, 1 + coolants_);
    right.col(0) = thermal_.inputs * c.q;
    if (thermal_.local && state.temperature.size() > 0) {
      thermal_.local->evaluate(state.temperature, state.temperature, c, state.local);
      if (!state.local.empty()) right.col(0) += state.local.source - state.local.conduction * state.temperature;
    }
    const VectorXd q0 = c.q;
    for (Index i = 0; i < coolants_; ++i) {
      Coefficients unit = c;
      model_.coefficients(row_, VectorXd::Unit(coolants_, i), readings, unit);
      right.col(1 + i) = thermal_.inputs * (unit.q - q0);
    }
    // Coefficients that stand need no other factor.
    if (factored_.size() != c.p.size() || (factored_ - c.p).cwiseAbs().maxCoeff() > 0.0) {
      direct_.factorise(c.p, 0.0);
      factored_ = c.p;
    }
    const MatrixXd solved = direct_.solve(right);
    state.inlet_K = inlets(solved);
    state.temperature = solved.col(0) + solved.rightCols(coolants_) * state.inlet_K;
    model_.coefficients(row_, state.inlet_K, readings, c);
  }

  /// How far each chiller is from its rule with these inlets, K.
  VectorXd off_rule(const MatrixXd& at_readings, const VectorXd& inlet) const {
    const VectorXd readings = at_readings.col(0) + at_readings.rightCols(coolants_) * inlet;
    const VectorXd set = chiller_set_points(machine_, thermal_.layout, readings, guide_);
    VectorXd off(coolants_);
    for (Index i = 0; i < coolants_; ++i) {
      switch (rules_[i]) {
        case Rule::off: off[i] = inlet[i]; break;  // no flow: without effect
        case Rule::given: off[i] = inlet[i] - given_inlet(i); break;
        case Rule::outlet_at_set: off[i] = inlet[i] - set[i]; break;
        case Rule::return_at_set: off[i] = readings[returns(i)] - set[i]; break;
        case Rule::limited: off[i] = readings[returns(i)] - cooling_[i] - inlet[i]; break;
      }
    }
    return off;
  }

  /// The inlets at which all rules hold: each is affine in the inlets.
  VectorXd inlets(const MatrixXd& solved) {
    if (coolants_ == 0) return {};
    MatrixXd at_readings = thermal_.sensors * solved;
    at_readings.col(0) += offsets_;
    for (Index i = 0; i < coolants_; ++i) rules_[i] = rule_of(i);
    for (int tries = 0;; ++tries) {
      const VectorXd off = off_rule(at_readings, VectorXd::Zero(coolants_));
      MatrixXd slope(coolants_, coolants_);
      for (Index i = 0; i < coolants_; ++i) slope.col(i) = off_rule(at_readings, VectorXd::Unit(coolants_, i)) - off;
      const Eigen::FullPivLU<MatrixXd> lu(slope);
      if (!lu.isInvertible()) {
        throw core::SolverError(
            "steady state: a chiller has no effect on what it controls, or follows itself without limit");
      }
      VectorXd inlet = -lu.solve(off);
      if (tries > coolants_ || !limit(at_readings, inlet)) return inlet;
    }
  }

  /// @return whether a chiller is asked for more or less than it can do; it then keeps to its limit
  bool limit(const MatrixXd& at_readings, const VectorXd& inlet) {
    const VectorXd readings = at_readings.col(0) + at_readings.rightCols(coolants_) * inlet;
    bool any = false;
    for (Index i = 0; i < coolants_; ++i) {
      if (rules_[i] != Rule::return_at_set && rules_[i] != Rule::outlet_at_set) continue;
      if (returns(i) < 0) continue;
      const auto [least, most] = limits(i);
      const double cooling = readings[returns(i)] - inlet[i];
      if (cooling >= least - 1e-9 && cooling <= most + 1e-9) continue;
      rules_[i] = Rule::limited;
      cooling_[i] = std::clamp(cooling, least, most);
      any = true;
    }
    return any;
  }

  SteadyState finished(SteadyState& state) const {
    state.sensors_K = read(state.temperature).head(std::ssize(machine_.sensors));
    for (Index i = 0; i < coolants_; ++i) {
      const bool controlled = rules_[i] == Rule::outlet_at_set || rules_[i] == Rule::return_at_set;
      if (controlled && machine_.coolants[i].control == mesh::ChillerControl::two_point) state.switching.push_back(i);
      if (rules_[i] == Rule::limited) state.at_limit.push_back(i);
    }
    return std::move(state);
  }

  const ThermalSystem& thermal_;
  const OperatingModel& model_;
  const mesh::Machine& machine_;
  const VectorXd& row_;
  const VectorXd guide_, offsets_;
  ThermalDirectSolver direct_;
  VectorXd factored_;  // p of the factor
  const Index coolants_;
  std::vector<Rule> rules_;
  VectorXd cooling_;  // (coolants) K, of those at a limit
};

}  // namespace

SteadyState steady_state(const ThermalSystem& thermal, const OperatingModel& model, const VectorXd& row) {
  return SteadySolver(thermal, model, row).solve();
}

std::vector<SteadyPhase> steady_phases(const LoadProgram& program) {
  std::vector<SteadyPhase> phases;
  double start = 0.0;
  for (const double end : program.stops()) {
    if (!program.is_corner(end)) continue;
    const double middle = 0.5 * (start + end);
    phases.push_back({program.phase_at(middle), start, end, program.row_at(end, middle)});
    start = end;
  }
  return phases;
}

}  // namespace thermotwin::solver
