// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/integrator.h"

#include <fmt/format.h>
#include <iterator>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/thread_pool.h"
#include "solver/thermal/iteration.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int factor_price = 16;  // a factorisation costs about as much as this many iterations
constexpr std::size_t most_factors = 24;

}  // namespace

struct ThermalIntegrator::Work : ThermalIteration {
  explicit Work(const ThermalSystem& system, const IntegratorOptions& integrator_options)
      : ThermalIteration(system),
        options(integrator_options) {}

  IntegratorOptions options;
  long excess = 0;       // iterations that new factors might have saved, since the last ones
  bool settled = false;  // neither coefficients nor the step changed in this step
  SideBySide temperature, source, q, ex, kx, imbalance;
  MatrixXd step_mean;  // of the step's stages, if it is kept

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
      if (sets.size() == 1 ||
          (sets.size() <= most_factors && memory * static_cast<double>(sets.size()) <= options.factor_memory))
        return sets;
      wanted.assign(loads.size(), 0);
    }
    VectorXd mean = loads.front().p;
    for (std::size_t l = 1; l < loads.size(); ++l) mean += loads[l].p;
    sets = {mean / static_cast<double>(loads.size())};
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
    statistics.factorisations += static_cast<long>(sets.size());
    return true;
  }

  /// As iterate, with the tolerance set from the residual at hand, and a second try with a fresh
  /// factor. @param scale  (loads) size of the terms that make up the residual
  void solve(const VectorXd& scale, bool want_capacity, Statistics& statistics) {
    start(scale, options.tolerance);
    bool done = iterate(options.max_iterations, want_capacity);
    count_iterations(statistics);
    if (!done && make_factors(statistics)) {
      update_fluid_factors();
      done = iterate(options.max_iterations, want_capacity);
      count_iterations(statistics);
    }
    if (!done) require_done(options.max_iterations);
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
    return excess >= factor_price && excess >= factor_price * static_cast<long>(wanted_factors(wanted).size());
  }
};

ThermalIntegrator::ThermalIntegrator(const ThermalSystem& system, const IntegratorOptions& options)
    : system_(system),
      options_(options),
      work_(std::make_unique<Work>(system, options)) {}

ThermalIntegrator::~ThermalIntegrator() = default;

VectorXd ThermalIntegrator::uniform(double temperature_K) const { return VectorXd::Constant(size(), temperature_K); }

MatrixXd ThermalIntegrator::sensors(const MatrixXd& state) const { return system_.sensors * state; }

void ThermalIntegrator::advance(MatrixXd& state, const std::vector<Coefficients>& c, double step_s) {
  Work& work = *work_;
  const Index loads = state.cols();
  if (std::ssize(c) != loads || state.rows() != size() || !(step_s > 0.0))
    throw core::SolverError(fmt::format("thermal step: {} x {} states, {} sets of coefficients, step {} s",
                                        state.rows(), loads, c.size(), step_s));
  const double gamma = options_.backward_euler ? 1.0 : sdirk_gamma;
  const bool shift_changed = std::abs(gamma * step_s * work.shift - 1.0) > Work::same_shift;
  if (shift_changed) work.shift = 1.0 / (gamma * step_s);
  const double shift = work.shift;
  work.loads.resize(loads);
  put_side_by_side(state, work.temperature);
  SideBySide q(c.front().q.size(), loads);
  std::vector<char> changed(c.size());
  for (std::size_t l = 0; l < c.size(); ++l) {
    changed[l] = work.set_coefficients(l, c[l].p);
    if (shift_changed) work.loads[l].changed = true;
    q.col(l) = c[l].q;
  }
  if (q.rows() != work.q.rows() || q.cols() != work.q.cols() || q != work.q) {
    work.source = system_.inputs * q;
    work.q = q;
  }
  for (std::size_t l = 0; l < c.size(); ++l)
    if (!work.loads[l].local.empty()) {
      // Another one in the next step: the product above must then be made anew.
      work.source.col(l) += work.loads[l].local.source;
      work.q.resize(0, 0);
    }

  work.settled = !shift_changed && std::none_of(changed.begin(), changed.end(), [](char x) { return x != 0; });

  if (work.factors.empty() || work.factors_pay()) work.make_factors(statistics_);
  work.update_fluid_factors();

  work.multiply(work.temperature, work.ex, work.kx);
  const VectorXd scale = shift * norms(work.ex) + norms(work.kx) + norms(work.source);

  // Stage 1: (E / (gamma h) + K) d = f - K T, then T + d is the temperature at gamma h.
  work.imbalance.resize(size(), loads);
  work.residual.resize(size(), loads);
  double *imbalance = work.imbalance.data(), *temperature = work.temperature.data();
  over_entries(work.imbalance, [&](Index first, Index last) {
    for (Index i = first; i < last; ++i)
      work.residual.data()[i] = imbalance[i] = work.source.data()[i] - work.kx.data()[i];
  });
  work.solve(scale, !options_.backward_euler, statistics_);
  if (!options_.backward_euler) {
    // Stage 2 starts from U = T + a d with a = (1 - gamma) / gamma; K d follows from A d, which the
    // iteration has left as the change of the residual.
    const double a = (1.0 - gamma) / gamma;
    double* residual = work.residual.data();
    const double *increment = work.increment.data(), *stored = work.capacity_increment.data();
    over_entries(work.imbalance, [&](Index first, Index last) {
      for (Index i = first; i < last; ++i) {
        const double conducted = imbalance[i] - residual[i] - shift * stored[i];
        temperature[i] += a * increment[i];
        residual[i] = imbalance[i] - a * conducted;
      }
    });
    // The first stage ends at T + d.
    if (options_.keep_mean) work.step_mean = (1.0 - gamma) * (work.temperature - (a - 1.0) * work.increment);
    // Factors that have just been seen to solve this matrix at once need no second look.
    const bool seen = work.factors_are_exact() && std::all_of(work.loads.begin(), work.loads.end(),
                                                              [](const auto& load) { return load.iterations == 1; });
    if (seen) {
      work.solve_once();
      work.count_iterations(statistics_);
    } else {
      work.solve(scale, false, statistics_);
    }
  }
  over_rows(
      size(),
      [&](Index first, Index last) {
        state.middleRows(first, last - first) =
            work.temperature.middleRows(first, last - first) + work.increment.middleRows(first, last - first);
      },
      256);
  if (options_.keep_mean) {
    if (options_.backward_euler)
      work.step_mean = state;
    else
      work.step_mean += gamma * state;
  }
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
  out.count(static_cast<std::int64_t>(work.factors.size()));
  for (const auto& factor : work.factors) {
    out.matrix(factor->p);
    out.number(factor->shift);
  }
  out.count(static_cast<std::int64_t>(work.loads.size()));
  for (const Work::Load& load : work.loads) {
    out.matrix(load.p);
    out.count(static_cast<std::int64_t>(load.factor));
  }
  for (long value : {statistics_.steps, statistics_.factorisations, statistics_.iterations}) out.count(value);
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
}

}  // namespace thermotwin::solver
