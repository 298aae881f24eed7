// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/thread_pool.h"
#include "solver/thermal_operator.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t kept_directions = 30;  // GCR forgets the oldest beyond that
constexpr double rounding = 1e-15;           // residuals below this share of the terms are noise
constexpr int factor_price = 16;             // a factorisation costs about as much as this many iterations
constexpr std::size_t most_factors = 24;
constexpr double factor_memory = 1e9;        // bytes that factors of their own may take
constexpr double same_step = 1e-11;          // relative: differences of times carry rounding errors

}  // namespace

struct ThermalIntegrator::Work {
  explicit Work(const ThermalSystem& system) : op(system) {}

  struct Direction {
    VectorXd z, az, ez;  // search direction, A z with norm 1, E z
  };
  struct Load {
    VectorXd p, k_values;        // coefficients and the matrix they give
    BlockSolver::FluidFactor fluids;
    std::size_t factor = 0;      // index of the one that serves as preconditioner
    std::vector<Direction> directions;
    double threshold = 0;        // residual norm that ends the iteration
    int iterations = 0;
    bool changed = false;
  };

  /// What a factor was made of.
  struct Factor {
    BlockSolver solver;
    VectorXd p;
    double shift = 0;
  };

  ThermalOperator op;
  std::vector<Load> loads;
  std::vector<std::unique_ptr<Factor>> factors;
  double shift = 0;              // of the matrices now
  long excess = 0;               // iterations that new factors might have saved, since the last ones
  bool settled = false;          // neither coefficients nor the step changed in this step
  MatrixXd source, residual, increment, capacity_increment, ex, kx, packed, preconditioned;
  std::vector<std::size_t> active;

  /// What the factors should be made of now: while everything stands, the coefficients of each set
  /// of loads that share them, if there are not too many of these; else the mean of all loads.
  /// @param wanted  receives the place in the result for each load
  std::vector<VectorXd> wanted_factors(std::vector<std::size_t>& wanted) const {
    std::vector<VectorXd> sets;
    wanted.assign(loads.size(), 0);
    const double memory = factors.empty() ? 0.0 : factors.front()->solver.factor().memory_bytes();
    if (settled) {
      for (std::size_t l = 0; l < loads.size(); ++l) {
        wanted[l] = static_cast<std::size_t>(std::find(sets.begin(), sets.end(), loads[l].p) - sets.begin());
        if (wanted[l] == sets.size()) sets.push_back(loads[l].p);
      }
      if (sets.size() == 1 || (sets.size() <= most_factors && memory * static_cast<double>(sets.size()) <= factor_memory))
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
  bool factorise(Statistics& statistics) {
    std::vector<std::size_t> wanted;
    const std::vector<VectorXd> sets = wanted_factors(wanted);
    excess = 0;
    if (!factors.empty() && are_current(sets, wanted)) return false;
    while (factors.size() < sets.size()) {
      factors.push_back(std::make_unique<Factor>());
      if (factors.size() > 1) factors.back()->solver.adopt(factors.front()->solver);
    }
    factors.resize(sets.size());
    core::parallel_for(0, sets.size(), [&](std::size_t i) {
      Factor& factor = *factors[i];
      if (factor.shift == shift && factor.p.size() == sets[i].size() && factor.p == sets[i]) return;
      factor.p = sets[i];
      factor.shift = shift;
      VectorXd k_values;
      op.combine(factor.p, k_values);
      factor.solver.factorise(op, k_values, shift);
    });
    for (std::size_t l = 0; l < loads.size(); ++l) {
      loads[l].factor = wanted[l];
      loads[l].changed = true;
    }
    statistics.factorisations += static_cast<long>(sets.size());
    return true;
  }

  void update_fluid_factors() {
    core::parallel_for(0, loads.size(), [&](std::size_t l) {
      Load& load = loads[l];
      if (load.changed) load.fluids = factors[load.factor]->solver.fluid_factor(op.fluid_block(load.k_values, shift));
      load.changed = false;
    });
  }

  /// One GCR step of a load with its preconditioned residual.
  void gcr_step(std::size_t l, Eigen::Ref<VectorXd> z) {
    Load& load = loads[l];
    const auto column = static_cast<Index>(l);
    factors[load.factor]->solver.finish(z, load.fluids);
    const std::size_t slot = static_cast<std::size_t>(load.iterations) % kept_directions;
    const std::size_t kept = std::min(static_cast<std::size_t>(load.iterations), kept_directions);
    if (load.directions.size() <= slot) load.directions.resize(slot + 1);
    Direction fresh;
    std::swap(fresh, load.directions[slot]);
    fresh.z = z;
    fresh.ez.resize(z.size());
    fresh.az.resize(z.size());
    op.multiply(load.k_values, z.data(), fresh.ez.data(), fresh.az.data());
    fresh.az += shift * fresh.ez;
    for (std::size_t d = 0; d < kept; ++d) {
      if (d == slot) continue;
      const Direction& old = load.directions[d];
      const double overlap = fresh.az.dot(old.az);
      fresh.az -= overlap * old.az;
      fresh.z -= overlap * old.z;
      fresh.ez -= overlap * old.ez;
    }
    const double norm = fresh.az.norm();
    if (norm > 0.0) {
      const double scale = 1.0 / norm;
      fresh.az *= scale;
      fresh.z *= scale;
      fresh.ez *= scale;
      const double length = residual.col(column).dot(fresh.az);
      increment.col(column) += length * fresh.z;
      capacity_increment.col(column) += length * fresh.ez;
      residual.col(column) -= length * fresh.az;
    }
    std::swap(fresh, load.directions[slot]);
    ++load.iterations;
  }

  std::size_t factor_of(Index active_column) const { return loads[active[static_cast<std::size_t>(active_column)]].factor; }

  /// Iterates A d = residual for all loads; residual becomes what is left, increment d,
  /// capacity_increment E d. @return false if a load needs more than limit iterations
  bool iterate(int limit) {
    for (Load& load : loads) load.iterations = 0;
    for (int i = 0; i <= limit; ++i) {
      active.clear();
      for (std::size_t l = 0; l < loads.size(); ++l)
        if (!(residual.col(static_cast<Index>(l)).norm() <= loads[l].threshold)) active.push_back(l);
      if (active.empty()) return true;
      if (i == limit) return false;
      // Loads of one factor side by side: it is read once for all of them.
      std::stable_sort(active.begin(), active.end(), [&](std::size_t a, std::size_t b) { return loads[a].factor < loads[b].factor; });
      const auto count = static_cast<Index>(active.size());
      packed.resize(residual.rows(), count);
      preconditioned.resize(residual.rows(), count);
      for (Index a = 0; a < count; ++a) packed.col(a) = residual.col(static_cast<Index>(active[static_cast<std::size_t>(a)]));
      std::vector<Index> first;  // column of each factor's first load, then the end
      for (Index a = 0; a < count; ++a)
        if (a == 0 || factor_of(a) != factor_of(a - 1)) first.push_back(a);
      first.push_back(count);
      core::parallel_for(0, first.size() - 1, [&](std::size_t g) {
        const Index width = first[g + 1] - first[g];
        factors[factor_of(first[g])]->solver.solve_bodies(packed.middleCols(first[g], width), preconditioned.middleCols(first[g], width));
      });
      core::parallel_for(0, active.size(), [&](std::size_t a) { gcr_step(active[a], preconditioned.col(static_cast<Index>(a))); });
    }
    return false;
  }

  /// As iterate, with the tolerance set from the residual at hand, and a second try with a fresh
  /// factor. @param scale  (loads) size of the terms that make up the residual
  void solve(const VectorXd& scale, const IntegratorOptions& options, Statistics& statistics) {
    for (std::size_t l = 0; l < loads.size(); ++l)
      loads[l].threshold = std::max(options.tolerance * residual.col(static_cast<Index>(l)).norm(), rounding * scale[static_cast<Index>(l)]);
    increment.setZero(residual.rows(), residual.cols());
    capacity_increment.setZero(residual.rows(), residual.cols());
    bool done = iterate(options.max_iterations);
    count_iterations(options, statistics);
    if (!done && factorise(statistics)) {
      update_fluid_factors();
      done = iterate(options.max_iterations);
      count_iterations(options, statistics);
    }
    if (done) return;
    for (std::size_t l = 0; l < loads.size(); ++l) {
      const double left = residual.col(static_cast<Index>(l)).norm();
      if (!(left <= loads[l].threshold))
        throw core::SolverError(fmt::format(
            "thermal step: load {} of {} has a residual of {:.2e} W where {:.2e} W is allowed, after {} iterations", l + 1,
            loads.size(), left, loads[l].threshold, options.max_iterations));
    }
  }

  void count_iterations(const IntegratorOptions& options, Statistics& statistics) {
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
    : system_(system), options_(options), work_(std::make_unique<Work>(system)) {}

ThermalIntegrator::~ThermalIntegrator() = default;

VectorXd ThermalIntegrator::uniform(double temperature_K) const { return VectorXd::Constant(size(), temperature_K); }

MatrixXd ThermalIntegrator::sensors(const MatrixXd& state) const { return system_.sensors * state; }

void ThermalIntegrator::advance(MatrixXd& state, const std::vector<Coefficients>& c, double step_s) {
  Work& work = *work_;
  const Index loads = state.cols();
  if (static_cast<Index>(c.size()) != loads || state.rows() != size() || !(step_s > 0.0))
    throw core::SolverError(fmt::format("thermal step: {} x {} states, {} sets of coefficients, step {} s", state.rows(),
                                        loads, c.size(), step_s));
  const double gamma = options_.backward_euler ? 1.0 : sdirk_gamma;
  const bool shift_changed = std::abs(gamma * step_s * work.shift - 1.0) > same_step;
  if (shift_changed) work.shift = 1.0 / (gamma * step_s);
  const double shift = work.shift;
  work.loads.resize(static_cast<std::size_t>(loads));
  work.source.resize(size(), loads);
  std::vector<char> changed(c.size());
  core::parallel_for(0, c.size(), [&](std::size_t l) {
    Work::Load& load = work.loads[l];
    const bool p_changed = load.p.size() != c[l].p.size() || load.p != c[l].p;
    if (p_changed) {
      load.p = c[l].p;
      work.op.combine(load.p, load.k_values);
    }
    changed[l] = p_changed;
    load.changed = load.changed || p_changed || shift_changed;
    work.source.col(static_cast<Index>(l)).noalias() = system_.inputs * c[l].q;
  });

  work.settled = !shift_changed && std::none_of(changed.begin(), changed.end(), [](char x) { return x != 0; });

  if (work.factors.empty() || work.factors_pay()) work.factorise(statistics_);
  work.update_fluid_factors();

  work.ex.resize(size(), loads);
  work.kx.resize(size(), loads);
  VectorXd scale(loads);
  core::parallel_for(0, c.size(), [&](std::size_t i) {
    const auto l = static_cast<Index>(i);
    work.op.multiply(work.loads[i].k_values, state.col(l).data(), work.ex.col(l).data(), work.kx.col(l).data());
    scale[l] = shift * work.ex.col(l).norm() + work.kx.col(l).norm() + work.source.col(l).norm();
  });

  // Stage 1: (E / (gamma h) + K) d = f - K T, then T + d is the temperature at gamma h.
  const MatrixXd imbalance = work.source - work.kx;
  work.residual = imbalance;
  work.solve(scale, options_, statistics_);
  if (options_.backward_euler) {
    state += work.increment;
  } else {
    // Stage 2 starts from U = T + a d with a = (1 - gamma) / gamma; K d follows from A d, which the
    // iteration has left as the change of the residual.
    const double a = (1.0 - gamma) / gamma;
    const MatrixXd conducted = imbalance - work.residual - shift * work.capacity_increment;
    state += a * work.increment;
    work.residual = imbalance - a * conducted;
    work.solve(scale, options_, statistics_);
    state += work.increment;
  }
  ++statistics_.steps;
}

}  // namespace thermotwin::solver
