// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/adaptive.h"

#include <algorithm>
#include <cmath>

#include "core/range.h"
#include "solver/thermal/iteration.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double c = tr_bdf2_stage;
constexpr double d = 0.5 * tr_bdf2_stage;
constexpr double bdf2_lead = 1.0 / (c * (2.0 - c));  // T0 + bdf2_lead (Tc - T0) is where stage 2 starts
constexpr double sqrt2 = 1.4142135623730951;
// Weights of the slopes at 0, c h, h: second minus third order, over d.
constexpr double error_0 = (sqrt2 - 1.0) / (3.0 * d), error_c = -1.0 / (3.0 * d), error_h = 2.0 / 3.0;
constexpr int factor_price = 16;  // a factorisation costs about as much as this many iterations
constexpr std::size_t most_factors = 24;
constexpr double estimate_tolerance = 1e-3;  // of an error that is compared with a tolerance

}  // namespace

struct AdaptiveIntegrator::Work : ThermalIteration {
  Work(const ThermalSystem& system, const AdaptiveOptions& o) : ThermalIteration(system), options(o) {
    loads.resize(1);
    single_precision = o.single_precision;
  }

  AdaptiveOptions options;
  /// Iterations that a factor for these coefficients and this step would have saved so far.
  struct Debt {
    VectorXd p;
    double shift;
    long iterations;
  };
  std::vector<Debt> debts;
  long clock = 0;

  Debt& debt_of(const VectorXd& p) {
    for (Debt& debt : debts)
      if (std::abs(debt.shift / shift - 1.0) <= same_shift && debt.p == p) return debt;
    // Old debts of steps that never came again are forgotten.
    if (debts.size() >= 4 * most_factors) debts.erase(debts.begin());
    debts.push_back({p, shift, 0});
    return debts.back();
  }

  /// The factor of (p, shift); else of the same coefficients or the same step; else the one whose
  /// step is nearest.
  std::size_t best_factor(const VectorXd& p) const {
    std::size_t best = 0;
    double best_score = 1e300;
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const double apart = fits(*factors[i], shift) ? 0.0 : std::abs(std::log2(factors[i]->shift / shift));
      // Other coefficients cost about as much as another half octave of the step.
      const double score = apart + (factors[i]->p == p ? 0.0 : 0.5);
      if (score < best_score || (score == best_score && factors[i]->last_use > factors[best]->last_use)) {
        best = i;
        best_score = score;
      }
    }
    return best;
  }

  void make_factor(const VectorXd& p, Statistics& statistics) {
    const double each = factors.empty() ? 0.0 : factors.front()->solver.memory_bytes();
    const std::size_t room =
        std::min(most_factors, 1 + static_cast<std::size_t>(each > 0.0 ? options.factor_memory / each : most_factors));
    std::size_t at = factors.size();
    if (factors.size() < room) {
      factors.push_back(new_factor());
    } else {
      at = 0;
      for (std::size_t i = 1; i < factors.size(); ++i)
        if (factors[i]->last_use < factors[at]->last_use) at = i;
    }
    factorise(*factors[at], p, shift);
    ++statistics.factorisations;
    statistics.most_factors = std::max<long>(statistics.most_factors, std::ssize(factors));
    std::erase_if(debts, [&](const Debt& debt) { return debt.shift == shift && debt.p == p; });
    choose(at);
  }

  void choose(std::size_t factor) {
    loads[0].factor = factor;
    loads[0].changed = true;
    factors[factor]->last_use = ++clock;
    update_fluid_factors();
  }

  bool exact(const VectorXd& p) const {
    const Factor& factor = *factors[loads[0].factor];
    return fits(factor, shift) && factor.p == p;
  }

  void solve(double scale, double tolerance, Statistics& statistics) {
    const VectorXd& p = loads[0].p;
    if (!exact(p) && debt_of(p).iterations >= factor_price) make_factor(p, statistics);
    start(VectorXd::Constant(1, scale), tolerance);
    bool done = iterate(options.max_iterations);
    const auto count = [&] {
      statistics.iterations += loads[0].iterations;
      if (!exact(p)) debt_of(p).iterations += std::max(0, loads[0].iterations - 1);
    };
    count();
    if (!done && !exact(p)) {
      make_factor(p, statistics);
      done = iterate(options.max_iterations);
      count();
    }
    if (!done) require_done(options.max_iterations);
    ++statistics.solves;
  }

  /// As solve, after one with the same matrix: a factor that has just been seen to solve it at once
  /// needs no second look. What is left of the right-hand side is then not known.
  void solve_again(double scale, double tolerance, bool want_capacity, Statistics& statistics) {
    if (loads[0].iterations != 1 || !factors_are_exact()) return solve(scale, tolerance, statistics);
    solve_once();
    if (want_capacity) op.multiply_capacity(increment, capacity_increment);
    ++statistics.iterations;
    ++statistics.solves;
  }
};

void AdaptiveOptions::validate() const {
  const std::string of = "adaptive options: ";
  core::require_within(of + "tolerance", tolerance, {1e-16, 1.0});
  core::require_within(of + "max_iterations", max_iterations, {1.0, 1e9});
  core::require_within(of + "factor_memory", factor_memory, core::non_negative);
}

AdaptiveIntegrator::AdaptiveIntegrator(const ThermalSystem& system, const AdaptiveOptions& options)
    : system_(system),
      work_(std::make_unique<Work>(system, options)) {
  options.validate();
}

AdaptiveIntegrator::~AdaptiveIntegrator() = default;

void AdaptiveIntegrator::attempt(const VectorXd& start, const VectorXd& p, const std::array<VectorXd, 3>& q,
                                 double step_s, bool on_ladder, Step& result, bool want_error) {
  Work& work = *work_;
  const bool shift_changed = !(std::abs(d * step_s * work.shift - 1.0) <= Work::same_shift);
  if (shift_changed) work.shift = 1.0 / (d * step_s);
  const double shift = work.shift;
  const bool p_changed = work.set_coefficients(0, p);
  if (work.factors.empty()) {
    work.make_factor(p, statistics_);
  } else if (shift_changed || p_changed) {
    work.choose(work.best_factor(p));
    // Every step of the ladder gets its factor; for other coefficients it may do as it is.
    if (on_ladder && !work.fits(*work.factors[work.loads[0].factor], shift)) work.make_factor(p, statistics_);
  }

  VectorXd f_start = system_.inputs * q[0], f_stage = system_.inputs * q[1], f_end = system_.inputs * q[2];
  if (!work.loads[0].local.empty())
    for (VectorXd* f : {&f_start, &f_stage, &f_end}) *f += work.loads[0].local.source;
  SideBySide all_ex, all_kx;
  work.multiply(start, all_ex, all_kx);
  const VectorXd ex = all_ex.col(0), kx = all_kx.col(0);
  const double scale = shift * ex.norm() + kx.norm() + f_end.norm();

  // Trapezoidal rule: (E / (d h) + K) D = (f0 - K T0) + (fc - K T0).
  const VectorXd slope_start = f_start - kx;
  VectorXd right = slope_start + (f_stage - kx);
  work.residual = right;
  work.solve(scale, work.options.tolerance, statistics_);
  const VectorXd stored = shift * work.capacity_increment.col(0);
  const VectorXd conducted = right - work.residual.col(0) - stored;  // K D
  const VectorXd slope_stage = stored - slope_start;
  result.stage = start + work.increment.col(0);

  // BDF2 from T0 + a D, increment D2: (E / (d h) + K) D2 = f1 - K (T0 + a D).
  result.end = start + bdf2_lead * work.increment.col(0);
  right = f_end - kx - bdf2_lead * conducted;
  work.residual = right;
  work.solve_again(scale, work.options.tolerance, want_error, statistics_);
  result.end += work.increment.col(0);
  constexpr double outer = 0.5 * bdf2_lead * c;  // E (T1 - T0) = h (outer (r0 + rc) + d r1), r = S q - K T
  result.mean = outer * (start + result.stage) + d * result.end;
  result.q_mean = outer * (q[0] + q[1]) + d * q[2];
  result.error_K = 0.0;
  if (!want_error) return;
  const VectorXd slope_end = shift * work.capacity_increment.col(0);

  work.residual = error_0 * slope_start + error_c * slope_stage + error_h * slope_end;
  work.solve_again(scale, estimate_tolerance, false, statistics_);
  result.error_K = work.increment.col(0).cwiseAbs().maxCoeff();
}

void AdaptiveIntegrator::linearise(const VectorXd& start, const VectorXd& end, const Coefficients& c) {
  if (system_.local) work_->linearise(0, start, end, c);
}

const LocalTerms::Change* AdaptiveIntegrator::local_change() const {
  return system_.local ? &work_->loads[0].local : nullptr;
}

void AdaptiveIntegrator::save(core::BinaryWriter& out) const {
  const Work& work = *work_;
  out.number(work.shift);
  out.count(work.clock);
  out.count(work.factors.size());
  for (const auto& factor : work.factors) {
    out.matrix(factor->p);
    out.number(factor->shift);
    out.count(factor->last_use);
  }
  out.count(work.debts.size());
  for (const Work::Debt& debt : work.debts) {
    out.matrix(debt.p);
    out.number(debt.shift);
    out.count(debt.iterations);
  }
  out.matrix(work.loads[0].p);
  out.count(work.loads[0].factor);
  for (long value : {statistics_.solves, statistics_.factorisations, statistics_.iterations, statistics_.most_factors})
    out.count(value);
}

void AdaptiveIntegrator::load(core::BinaryReader& in) {
  Work& work = *work_;
  work.shift = in.number();
  work.clock = in.count();
  work.factors.clear();
  for (std::int64_t count = in.count(); count > 0; --count) {
    auto factor = work.new_factor();
    const VectorXd p = in.matrix();
    work.factorise(*factor, p, in.number());
    factor->last_use = in.count();
    work.factors.push_back(std::move(factor));
  }
  work.debts.clear();
  for (std::int64_t count = in.count(); count > 0; --count) {
    Work::Debt debt;
    debt.p = in.matrix();
    debt.shift = in.number();
    debt.iterations = in.count();
    work.debts.push_back(std::move(debt));
  }
  const VectorXd p = in.matrix();
  if (p.size() > 0) work.set_coefficients(0, p);
  work.loads[0].factor = in.count();
  if (!work.factors.empty()) work.update_fluid_factors();
  for (long* value :
       {&statistics_.solves, &statistics_.factorisations, &statistics_.iterations, &statistics_.most_factors})
    *value = in.count();
}

}  // namespace thermotwin::solver
