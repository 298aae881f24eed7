// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/exact_stepper.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>

#include "core/error.h"
#include "solver/operation/layout.h"

namespace thermotwin::reduction {
namespace {

constexpr std::size_t kept_ladders = 4;  ///< programs alternate between a few states
constexpr double series_reach = 0.5;     ///< largest norm of h A that the series meets
constexpr int series_terms = 13;         ///< 0.5^13/14!: below rounding
constexpr double same_length = 1e-12;    ///< of an interval: rounding of its ends
constexpr std::size_t most_rungs = 60;
constexpr int sum_afresh_after = 256;  ///< added changes of inputs before their heat is summed anew

/// Propagators of one set of coefficients at rung_0, 2 rung_0, 4 rung_0 ...
class Ladder {
public:
  long last_use = 0;
  Eigen::VectorXd p;

  bool is_made() const { return !change_.empty(); }

  void make(Eigen::MatrixXd a, double step) {
    a_ = std::move(a);
    change_.clear();
    mean_.clear();
    const double norm = a_.cwiseAbs().rowwise().sum().maxCoeff();
    std::size_t levels = 0;
    shortest_ = step;
    while (norm * shortest_ > series_reach && levels < most_rungs) {
      shortest_ *= 0.5;
      ++levels;
    }
    const Eigen::Index r = a_.rows();
    const Eigen::MatrixXd z = shortest_ * a_;
    Eigen::MatrixXd mean = Eigen::MatrixXd::Identity(r, r);
    for (int j = series_terms; j >= 1; --j) {  // 1 - z/2 (1 - z/3 (1 - ...))
      mean = ((-1.0 / (j + 1)) * (z * mean)).eval();
      mean.diagonal().array() += 1.0;
    }
    change_.push_back(-z * mean);
    mean_.push_back(std::move(mean));
    for (std::size_t i = 0; i < levels; ++i) extend();
    for (Eigen::VectorXd* v : {&rate_, &term_, &sum_}) v->setZero(r);
  }

  /// x := x(t + step) under constant heat.
  void advance(Eigen::VectorXd& x, const Eigen::VectorXd& heat, double step) {
    const double nothing = same_length * step;
    while (step >= 2.0 * rung(change_.size() - 1) && change_.size() < most_rungs && worth_a_rung(step)) extend();
    double left = step;
    for (std::size_t i = change_.size(); i-- > 0;) {
      while (left >= rung(i) - nothing) {
        term_.noalias() = change_[i] * x;
        term_.noalias() += mean_[i] * (rung(i) * heat);
        x += term_;
        left -= rung(i);
      }
    }
    if (left > nothing) finish(x, heat, left);
  }

private:
  double rung(std::size_t i) const { return std::ldexp(shortest_, i); }
  bool worth_a_rung(double step) const { return step >= 8.0 * rung(change_.size() - 1); }

  void extend() {
    const Eigen::MatrixXd& d = change_.back();
    const Eigen::MatrixXd& mean = mean_.back();
    Eigen::MatrixXd next = mean;
    next.noalias() += 0.5 * (d * mean);
    Eigen::MatrixXd doubled = 2.0 * d;
    doubled.noalias() += d * d;
    mean_.push_back(std::move(next));
    change_.push_back(std::move(doubled));
  }

  /// Less than the shortest rung: x + phi_1(-h A) h (f - A x) by its series.
  void finish(Eigen::VectorXd& x, const Eigen::VectorXd& heat, double h) {
    rate_ = heat;
    rate_.noalias() -= a_ * x;
    term_ = h * rate_;
    sum_ = term_;
    for (int j = 1; j <= series_terms; ++j) {
      rate_.noalias() = a_ * term_;
      term_ = (-h / (j + 1)) * rate_;
      sum_ += term_;
    }
    x += sum_;
  }

  Eigen::MatrixXd a_;
  double shortest_ = 0;
  std::vector<Eigen::MatrixXd> change_, mean_;
  Eigen::VectorXd rate_, term_, sum_;
};

}  // namespace

struct ExactStepper::Work {
  const ReducedSystem& system;
  ExactOptions options;
  Statistics statistics;
  ReducedStepper passing;
  std::array<Ladder, kept_ladders> ladders;
  std::array<Eigen::VectorXd, kept_ladders> seen;  ///< coefficients that were passed
  std::size_t next_seen = 0;
  long uses = 0;
  bool identity_capacity;
  Eigen::PartialPivLU<Eigen::MatrixXd> capacity;
  Eigen::VectorXd heat, sum, q, column;  ///< heat = E^-1 sum, sum = inputs q
  int additions = sum_afresh_after;

  Work(const ReducedSystem& s, const ExactOptions& o)
      : system(s),
        options(o),
        passing(s, o.passing),
        identity_capacity(s.capacity == Eigen::MatrixXd::Identity(s.order(), s.order())) {
    if (!identity_capacity) capacity.compute(s.capacity);
    heat = sum = column = Eigen::VectorXd::Zero(s.order());
    q = Eigen::VectorXd::Zero(s.inputs.cols());
    for (Eigen::VectorXd& p : seen) p.setConstant(std::ssize(s.terms), -1.0);
  }

  /// Only what changed is added, as long as that is little.
  void set_heat(const Eigen::VectorXd& next) {
    Eigen::Index changed = 0;
    for (Eigen::Index k = 0; k < q.size(); ++k) changed += next(k) != q(k);
    if (changed == 0) return;
    if (++additions > sum_afresh_after || 4 * changed > q.size() || !sum.allFinite()) {
      sum.noalias() = system.inputs * next;
      additions = 0;
    } else {
      for (Eigen::Index k = 0; k < q.size(); ++k)
        if (next(k) != q(k)) sum += (next(k) - q(k)) * system.inputs.col(k);
    }
    q = next;
    if (identity_capacity) {
      heat = sum;
    } else {
      heat = capacity.solve(sum);
    }
  }

  Ladder* find(const Eigen::VectorXd& p) {
    for (Ladder& ladder : ladders)
      if (ladder.is_made() && ladder.p == p) return &ladder;
    return nullptr;
  }

  bool seen_before(const Eigen::VectorXd& p) {
    for (const Eigen::VectorXd& old : seen)
      if (old == p) return true;
    seen[next_seen] = p;
    next_seen = (next_seen + 1) % seen.size();
    return false;
  }

  Ladder& make(const Eigen::VectorXd& p, double step) {
    Ladder* oldest = &ladders[0];
    for (Ladder& ladder : ladders)
      if (ladder.last_use < oldest->last_use) oldest = &ladder;
    Eigen::MatrixXd a = system.conduction;
    for (Eigen::Index j = 0; j < p.size(); ++j)
      if (p(j) != 0.0) a += p(j) * system.terms[j];
    if (!identity_capacity) a = capacity.solve(a);
    oldest->p = p;
    oldest->make(std::move(a), step);
    ++statistics.ladders;
    return *oldest;
  }
};

ExactStepper::ExactStepper(const ReducedSystem& system, const ExactOptions& options) {
  options.validate();
  work_ = std::make_unique<Work>(system, options);
}
ExactStepper::~ExactStepper() = default;
ExactStepper::ExactStepper(ExactStepper&&) noexcept = default;

Eigen::Index ExactStepper::size() const { return work_->system.order(); }
const solver::Layout& ExactStepper::layout() const { return work_->system.layout; }
Eigen::VectorXd ExactStepper::uniform(double temperature_K) const { return work_->system.one_kelvin * temperature_K; }
const ExactStepper::Statistics& ExactStepper::statistics() const { return work_->statistics; }

void ExactStepper::advance(Eigen::VectorXd& state, const solver::Coefficients& c, double step_s) {
  Work& work = *work_;
  assert(state.size() == size() && step_s > 0.0);
  Ladder* ladder = work.find(c.p);
  if (!ladder && (work.options.from_first || work.seen_before(c.p)) && c.p.allFinite())
    ladder = &work.make(c.p, step_s);
  if (!ladder) {
    ++work.statistics.passed;
    work.passing.advance(state, c, step_s);
    return;
  }
  ++work.statistics.exact;
  ladder->last_use = ++work.uses;
  work.set_heat(c.q);
  ladder->advance(state, work.heat, step_s);
  if (!std::isfinite(state.sum())) {
    throw core::SolverError(fmt::format(
        "reduced model: the state is no longer finite after a step of {} s; look for NaN in the inputs", step_s));
  }
}

void ExactStepper::advance(Eigen::MatrixXd& state, const std::vector<solver::Coefficients>& c, double step_s) {
  assert(state.cols() == std::ssize(c));
  for (std::size_t load = 0; load < c.size(); ++load) {
    const Eigen::Index i = load;
    work_->column = state.col(i);
    advance(work_->column, c[load], step_s);
    state.col(i) = work_->column;
  }
}

Eigen::MatrixXd ExactStepper::sensors(const Eigen::MatrixXd& state) const { return work_->system.sensors * state; }

}  // namespace thermotwin::reduction
