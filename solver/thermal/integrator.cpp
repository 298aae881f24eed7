// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/integrator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "solver/thermal/iteration.h"
#include "solver/thermal/system.h"
#include "solver/thermal/warm_start.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int factor_price = 16;  // a factorisation costs about as much as this many iterations
constexpr std::size_t most_factors = 24;

}  // namespace

struct ThermalIntegrator::Work : ThermalIteration {
  explicit Work(const ThermalSystem& of_system, const IntegratorOptions& integrator_options)
      : ThermalIteration(of_system),
        system(of_system),
        options(integrator_options),
        warm(integrator_options.recycled) {}

  const ThermalSystem& system;
  IntegratorOptions options;
  long excess = 0;       // iterations that new factors might have saved, since the last ones
  bool settled = false;  // neither coefficients nor the step changed in this step
  SideBySide temperature, source, q, ex, kx, imbalance;
  MatrixXd step_mean;  // of the step's stages, if it is kept
  WarmStart warm;      // of steps with the present coefficients

  /// What the factors should be made of now: while everything stands, the coefficients of each set
  /// of loads that share them, if there are not too many of these; else the mean of all loads.
  /// @param wanted  receives the place in the result for each load
  std::vector<VectorXd> wanted_factors(std::vector<std::size_t>& wanted) const {
    std::vector<VectorXd> sets;
    wanted.assign(loads.size(), 0);
    const double memory = factors.empty() ? 0.0 : factors.front()->solver.memory_bytes();
    if (settled) {
      for (std::size_t l = 0; l < loads.size(); ++l) {
        wanted[l] = std::find(sets.begin(), sets.end(), loads[l].p) - sets.begin();
        if (wanted[l] == sets.size()) sets.push_back(loads[l].p);
      }
      if (sets.size() == 1 || (sets.size() <= most_factors && memory * sets.size() <= options.factor_memory))
        return sets;
      wanted.assign(loads.size(), 0);
    }
    VectorXd mean = loads.front().p;
    for (std::size_t l = 1; l < loads.size(); ++l) mean += loads[l].p;
    sets = {mean / std::ssize(loads)};
    return sets;
  }

  bool are_current(const std::vector<VectorXd>& sets, const std::vector<std::size_t>& wanted) const {
    for (std::size_t l = 0; l < loads.size(); ++l) {
      const Factor& factor = *factors[loads[l].factor];
      if (factor.shift != shift || factor.p != sets[wanted[l]]) return false;
    }
    return true;
  }

  /// @return false if the factors at hand are the best there are
  bool make_factors(Statistics& statistics) {
    std::vector<std::size_t> wanted;
    const std::vector<VectorXd> sets = wanted_factors(wanted);
    excess = 0;
    if (!factors.empty() && are_current(sets, wanted)) return false;
    while (factors.size() < sets.size()) factors.push_back(new_factor());
    factors.resize(sets.size());
    core::parallel_for(0, sets.size(), [&](std::size_t i) {
      Factor& factor = *factors[i];
      if (factor.shift == shift && factor.p.size() == sets[i].size() && factor.p == sets[i]) return;
      factorise(factor, sets[i], shift);
    });
    for (std::size_t l = 0; l < loads.size(); ++l) {
      loads[l].factor = wanted[l];
      loads[l].changed = true;
    }
    statistics.factorisations += std::ssize(sets);
    return true;
  }

  /// As iterate, with the tolerance set from the residual at hand, and a second try with a fresh
  /// factor. @param scale  (loads) size of the terms that make up the residual
  void solve(const VectorXd& scale, bool want_capacity, Statistics& statistics) {
    start(scale, options.tolerance);
    if (!settled) warm.clear();
    if (warm.guess(increment, residual)) has_guess();
    bool done = iterate(options.max_iterations, want_capacity);
    count_iterations(statistics);
    if (!done && make_factors(statistics)) {
      update_fluid_factors();
      done = iterate(options.max_iterations, want_capacity);
      count_iterations(statistics);
    }
    if (!done) require_done(options.max_iterations);
    warm.remember(increment, residual);
  }

  void count_iterations(Statistics& statistics) {
    // While everything stands still a new factor would save all but one; otherwise it may be as far
    // off in the next step as this one is now.
    const int worth = settled ? 1 : options.refactor_above;
    for (const Load& load : loads) {
      statistics.iterations += load.iterations;
      excess += std::max(0, load.iterations - worth);
    }
  }

  bool factors_pay() const {
    std::vector<std::size_t> wanted;
    return excess >= factor_price && excess >= factor_price * std::ssize(wanted_factors(wanted));
  }

  /// State, coefficients and sources of the step. @param stage_s  gamma h
  void take_over(const MatrixXd& state, const std::vector<Coefficients>& c, double stage_s) {
    const bool shift_changed = std::abs(stage_s * shift - 1.0) > same_shift;
    if (shift_changed) shift = 1.0 / stage_s;
    settled = !shift_changed;
    loads.resize(c.size());
    put_side_by_side(state, temperature);
    SideBySide powers(c.front().q.size(), state.cols());
    for (std::size_t l = 0; l < c.size(); ++l) {
      if (set_coefficients(l, c[l].p)) settled = false;
      if (shift_changed) loads[l].changed = true;
      powers.col(l) = c[l].q;
    }
    if (powers.rows() != q.rows() || powers.cols() != q.cols() || powers != q) {
      source = system.inputs * powers;
      q = powers;
    }
    for (std::size_t l = 0; l < c.size(); ++l) {
      if (!loads[l].local.empty()) {
        // Another one in the next step: the product above must then be made anew.
        source.col(l) += loads[l].local.source;
        q.resize(0, 0);
      }
    }
  }

  /// (E / (gamma h) + K) d = f - K T, then T + d is the temperature at gamma h.
  /// @return (loads) size of the terms that make up the residual
  VectorXd first_stage(Statistics& statistics) {
    multiply(temperature, ex, kx);
    const VectorXd scale = shift * norms(ex) + norms(kx) + norms(source);
    imbalance.resize(temperature.rows(), temperature.cols());
    residual.resize(temperature.rows(), temperature.cols());
    double *out = imbalance.data(), *right = residual.data();
    const double *heat = source.data(), *conducted = kx.data();
    over_entries(imbalance, [&](Index first, Index last) {
      for (Index i = first; i < last; ++i) right[i] = out[i] = heat[i] - conducted[i];
    });
    solve(scale, !options.backward_euler, statistics);
    return scale;
  }

  /// Starts from U = T + a d with a = (1 - gamma) / gamma; K d follows from A d, which the iteration
  /// has left as the change of the residual.
  void second_stage(double gamma, const VectorXd& scale, Statistics& statistics) {
    const double a = (1.0 - gamma) / gamma, over_stage = shift;
    double *to = temperature.data(), *right = residual.data();
    const double *before = imbalance.data(), *d = increment.data(), *stored = capacity_increment.data();
    over_entries(imbalance, [&](Index first, Index last) {
      for (Index i = first; i < last; ++i) {
        const double conducted = before[i] - right[i] - over_stage * stored[i];
        to[i] += a * d[i];
        right[i] = before[i] - a * conducted;
      }
    });
    // The first stage ends at T + d.
    if (options.keep_mean) step_mean = (1.0 - gamma) * (temperature - (a - 1.0) * increment);
    // Factors that have just been seen to solve this matrix at once need no second look.
    const bool seen = factors_are_exact() &&
                      std::all_of(loads.begin(), loads.end(), [](const Load& load) { return load.iterations == 1; });
    if (seen) {
      solve_once();
      count_iterations(statistics);
    } else {
      solve(scale, false, statistics);
    }
  }

  void put_end(MatrixXd& state, double gamma) {
    over_rows(
        state.rows(),
        [&](Index first, Index last) {
          state.middleRows(first, last - first) =
              temperature.middleRows(first, last - first) + increment.middleRows(first, last - first);
        },
        256);
    if (!options.keep_mean) return;
    if (options.backward_euler)
      step_mean = state;
    else
      step_mean += gamma * state;
  }
};

void IntegratorOptions::validate() const {
  const std::string of = "integrator options: ";
  core::require_within(of + "tolerance", tolerance, {1e-16, 1.0});
  core::require_within(of + "max_iterations", max_iterations, {1.0, 1e9});
  core::require_within(of + "refactor_above", refactor_above, {0.0, 1e9});
  core::require_within(of + "factor_memory", factor_memory, core::non_negative);
  core::require_within(of + "recycled", recycled, {0.0, 100.0});
}

ThermalIntegrator::ThermalIntegrator(const ThermalSystem& system, const IntegratorOptions& options)
    : system_(system),
      options_(options),
      work_(std::make_unique<Work>(system, options)) {
  options.validate();
}

ThermalIntegrator::~ThermalIntegrator() = default;

VectorXd ThermalIntegrator::uniform(double temperature_K) const { return VectorXd::Constant(size(), temperature_K); }

MatrixXd ThermalIntegrator::sensors(const MatrixXd& state) const { return system_.sensors * state; }

void ThermalIntegrator::advance(MatrixXd& state, const std::vector<Coefficients>& c, double step_s) {
  if (std::ssize(c) != state.cols() || state.rows() != size() || !(step_s > 0.0)) {
    throw core::SolverError(fmt::format("thermal step: {} x {} states, {} sets of coefficients, step {} s",
                                        state.rows(), state.cols(), c.size(), step_s));
  }
  Work& work = *work_;
  const double gamma = options_.backward_euler ? 1.0 : sdirk_gamma;
  work.take_over(state, c, gamma * step_s);
  if (work.factors.empty() || work.factors_pay()) work.make_factors(statistics_);
  work.update_fluid_factors();
  const VectorXd scale = work.first_stage(statistics_);
  if (!options_.backward_euler) work.second_stage(gamma, scale, statistics_);
  work.put_end(state, gamma);
  ++statistics_.steps;
}

const MatrixXd* ThermalIntegrator::mean_over_step() const { return options_.keep_mean ? &work_->step_mean : nullptr; }

const LocalTerms::Change* ThermalIntegrator::local_change(std::size_t load) const {
  return system_.local ? &work_->loads[load].local : nullptr;
}

void ThermalIntegrator::linearise(const MatrixXd& start, const MatrixXd& end, const std::vector<Coefficients>& c) {
  if (!system_.local) return;
  work_->loads.resize(c.size());
  core::parallel_for(0, c.size(), [&](std::size_t l) { work_->linearise(l, start.col(l), end.col(l), c[l]); });
}

void ThermalIntegrator::save(core::BinaryWriter& out) const {
  const Work& work = *work_;
  out.number(work.shift);
  out.count(work.excess);
  out.count(work.factors.size());
  for (const auto& factor : work.factors) {
    out.matrix(factor->p);
    out.number(factor->shift);
  }
  out.count(work.loads.size());
  for (const Work::Load& load : work.loads) {
    out.matrix(load.p);
    out.count(load.factor);
  }
  for (long value : {statistics_.steps, statistics_.factorisations, statistics_.iterations}) out.count(value);
  if (options_.recycled == 0) return;
  work.warm.save(out);
}

void ThermalIntegrator::load(core::BinaryReader& in) {
  Work& work = *work_;
  work.shift = in.number();
  work.excess = in.count();
  work.factors.clear();
  for (std::int64_t count = in.count(); count > 0; --count) {
    auto factor = work.new_factor();
    const VectorXd p = in.matrix();
    work.factorise(*factor, p, in.number());
    work.factors.push_back(std::move(factor));
  }
  work.loads.clear();
  work.loads.resize(in.count());
  for (std::size_t l = 0; l < work.loads.size(); ++l) {
    work.set_coefficients(l, in.matrix());
    work.loads[l].factor = in.count();
  }
  for (long* value : {&statistics_.steps, &statistics_.factorisations, &statistics_.iterations}) *value = in.count();
  if (options_.recycled == 0) return;
  work.warm.load(in);
}

}  // namespace thermotwin::solver
