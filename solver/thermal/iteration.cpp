// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/iteration.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr std::size_t kept_directions = 30;  // GCR forgets the oldest beyond that
constexpr double rounding = 1e-15;           // residuals below this share of the terms are noise

}  // namespace

ThermalIteration::ThermalIteration(const ThermalSystem& system) : op(system), local_(system.local.get()) {}

void ThermalIteration::linearise(std::size_t l, const VectorXd& start, const VectorXd& end, const Coefficients& c) {
  local_->evaluate(start, end, c, loads[l].local);
}

void ThermalIteration::multiply(const SideBySide& x, SideBySide& ex, SideBySide& kx) const {
  op.multiply(coefficients(), x, ex, kx);
  add_local(nullptr, 0.0, x, &ex, &kx);
}

void ThermalIteration::add_local(const std::vector<std::size_t>* load_of, double at_shift, const SideBySide& x,
                                 SideBySide* ex, SideBySide* ax) const {
  if (!local_) return;
  for (Index column = 0; column < x.cols(); ++column) {
    const LocalTerms::Change& local = loads[load_of ? (*load_of)[column] : column].local;
    if (local.empty()) continue;
    const VectorXd of = x.col(column), stored = local.capacity * of;
    if (ex) ex->col(column) += stored;
    if (ax) ax->col(column) += at_shift * stored + local.conduction * of;
  }
}

SideBySide ThermalIteration::coefficients() const {
  SideBySide p(loads.front().p.size(), std::ssize(loads));
  for (std::size_t l = 0; l < loads.size(); ++l) p.col(l) = loads[l].p;
  return p;
}

bool ThermalIteration::set_coefficients(std::size_t l, const VectorXd& p) {
  Load& load = loads[l];
  if (load.p.size() == p.size() && load.p == p) return false;
  load.p = p;
  load.changed = true;
  return true;
}

void ThermalIteration::factorise(Factor& factor, const VectorXd& p, double at_shift) const {
  factor.p = p;
  factor.shift = at_shift;
  factor.solver.factorise(op, p, at_shift, single_precision);
}

std::unique_ptr<ThermalIteration::Factor> ThermalIteration::new_factor() const {
  auto factor = std::make_unique<Factor>();
  if (!factors.empty()) factor->solver.adopt(factors.front()->solver);
  return factor;
}

void ThermalIteration::update_fluid_factors() {
  core::parallel_for(0, loads.size(), [&](std::size_t l) {
    Load& load = loads[l];
    if (load.changed) load.fluids = factors[load.factor]->solver.fluid_factor(op.fluid_block(load.p, shift));
    load.changed = false;
  });
}

void ThermalIteration::start(const VectorXd& scale, double tolerance) {
  const VectorXd norm = norms(residual);
  for (std::size_t l = 0; l < loads.size(); ++l)
    loads[l].threshold = std::max(tolerance * norm[l], rounding * scale[l]);
  increment.setZero(residual.rows(), residual.cols());
  capacity_increment.setZero(residual.rows(), residual.cols());
  started_ = true;
}

void ThermalIteration::borrow(const VectorXd& norm) {
  Working& w = working_;
  w.load.clear();
  for (std::size_t l = 0; l < loads.size(); ++l)
    if (!(norm[l] <= loads[l].threshold)) w.load.push_back(l);
  w.all = w.load.size() == loads.size();
  // Loads of one factor side by side: it is read once for all of them.
  const auto by_factor = [&](std::size_t a, std::size_t b) { return loads[a].factor < loads[b].factor; };
  w.all = w.all && std::is_sorted(w.load.begin(), w.load.end(), by_factor);
  std::stable_sort(w.load.begin(), w.load.end(), by_factor);
  w.p.resize(loads.front().p.size(), std::ssize(w.load));
  for (std::size_t c = 0; c < w.load.size(); ++c) w.p.col(c) = loads[w.load[c]].p;
  if (w.all) {
    w.residual.swap(residual);
    w.increment.swap(increment);
    return;
  }
  w.residual = residual(Eigen::all, w.load);
  w.increment = increment(Eigen::all, w.load);
}

void ThermalIteration::give_back() {
  Working& w = working_;
  if (w.all) {
    residual.swap(w.residual);
    increment.swap(w.increment);
  } else {
    residual(Eigen::all, w.load) = w.residual;
    increment(Eigen::all, w.load) = w.increment;
  }
  w.load.clear();
}

void ThermalIteration::drop_finished(const VectorXd& norm) {
  Working& w = working_;
  std::vector<Index> kept;
  std::vector<std::size_t> still;
  for (std::size_t c = 0; c < w.load.size(); ++c) {
    if (!(norm[c] <= loads[w.load[c]].threshold)) {
      kept.push_back(c);
      still.push_back(w.load[c]);
    }
  }
  if (kept.size() == w.load.size()) return;
  if (kept.empty()) return give_back();
  const auto keep = [&](SideBySide& block) { block = SideBySide(block(Eigen::all, kept)); };
  if (w.all) {
    // The members get their own back with all columns; what goes on is a copy.
    residual.swap(w.residual);
    increment.swap(w.increment);
    w.residual = residual(Eigen::all, kept);
    w.increment = increment(Eigen::all, kept);
    w.all = false;
  } else {
    residual(Eigen::all, w.load) = w.residual;
    increment(Eigen::all, w.load) = w.increment;
    keep(w.residual);
    keep(w.increment);
  }
  keep(w.p);
  for (Direction& direction : w.directions) {
    if (direction.z.cols() != std::ssize(w.load)) continue;  // of an earlier call
    keep(direction.z);
    keep(direction.az);
    direction.weight = Eigen::ArrayXd(direction.weight(kept));
  }
  w.load = still;
}

void ThermalIteration::precondition(SideBySide& z) const {
  const Working& w = working_;
  z.resize(w.residual.rows(), w.residual.cols());
  std::vector<std::size_t> first;  // column of each factor's first load, then the end
  for (std::size_t c = 0; c < w.load.size(); ++c)
    if (c == 0 || loads[w.load[c]].factor != loads[w.load[c - 1]].factor) first.push_back(c);
  first.push_back(w.load.size());
  core::parallel_for(0, first.size() - 1, [&](std::size_t g) {
    const Index begin = first[g], width = first[g + 1] - begin;
    std::vector<const BlockSolver::FluidFactor*> fluids;
    for (std::size_t c = first[g]; c < first[g + 1]; ++c) fluids.push_back(&loads[w.load[c]].fluids);
    factors[loads[w.load[first[g]]].factor]->solver.precondition(w.residual.middleCols(begin, width),
                                                                 z.middleCols(begin, width), fluids);
  });
}

VectorXd ThermalIteration::step(int iteration, bool with_capacity) {
  Working& w = working_;
  const std::size_t slot = iteration % kept_directions;
  const std::size_t kept = std::min<std::size_t>(iteration, kept_directions);
  if (w.directions.size() <= slot) w.directions.resize(slot + 1);
  Direction& fresh = w.directions[slot];
  precondition(fresh.z);
  op.multiply_shifted(w.p, shift, fresh.z, with_capacity ? &ez_ : nullptr, fresh.az);
  add_local(&w.load, shift, fresh.z, with_capacity ? &ez_ : nullptr, &fresh.az);
  const Index width = fresh.z.cols(), rows = fresh.z.rows();
  double *z = fresh.z.data(), *az = fresh.az.data();
  for (std::size_t d = 0; d < kept; ++d) {
    if (d == slot) continue;
    const Direction& old = w.directions[d];
    const Eigen::ArrayXd overlap = dots(fresh.az, old.az) * old.weight;
    const double *old_z = old.z.data(), *old_az = old.az.data(), *factor = overlap.data();
    over_rows(rows, [&](Index first, Index last) {
      for (Index i = first; i < last; ++i) {
        for (Index k = 0; k < width; ++k) {
          az[i * width + k] -= factor[k] * old_az[i * width + k];
          z[i * width + k] -= factor[k] * old_z[i * width + k];
        }
      }
    });
  }
  double *r = w.residual.data(), *x = w.increment.data();
  const Eigen::ArrayXd square = dots(fresh.az, fresh.az), along = dots(w.residual, fresh.az);
  fresh.weight = (square > 0.0).select(square.inverse(), 0.0);
  const Eigen::ArrayXd length = along * fresh.weight;
  double* e = ez_.data();
  return sum_rows(rows, width,
                  [&](Index i, double* sum, auto w_constant, Index begin) {
                    for (int k = 0; k < w_constant; ++k) {
                      const Index at = i * width + begin + k;
                      const double step = length[begin + k];
                      x[at] += step * z[at];
                      r[at] -= step * az[at];
                      if (with_capacity) e[at] *= step;
                      sum[k] += r[at] * r[at];
                    }
                  })
      .sqrt();
}

bool ThermalIteration::iterate(int limit, bool want_capacity) {
  for (Load& load : loads) load.iterations = 0;
  borrow(norms(residual));
  if (working_.load.empty() && started_) return true;
  const bool fresh = started_;
  started_ = false;
  bool e_is_current = false;
  for (int i = 0; !working_.load.empty() && i < limit; ++i) {
    for (const std::size_t l : working_.load) ++loads[l].iterations;
    // The first direction's E z is E d if no other follows.
    const bool with_capacity = want_capacity && i == 0 && fresh && working_.all;
    const VectorXd norm = step(i, with_capacity);
    if (with_capacity) capacity_increment.swap(ez_);
    e_is_current = with_capacity;
    drop_finished(norm);
  }
  const bool done = working_.load.empty();
  if (!done) give_back();
  if (want_capacity && !e_is_current) {
    op.multiply_capacity(increment, capacity_increment);
    add_local(nullptr, 0.0, increment, &capacity_increment, nullptr);
  }
  return done;
}

bool ThermalIteration::factors_are_exact() const {
  return std::all_of(loads.begin(), loads.end(), [&](const Load& load) {
    const Factor& factor = *factors[load.factor];
    return factor.solver.factor().is_direct() && fits(factor, shift) && factor.p == load.p && load.local.empty();
  });
}

void ThermalIteration::solve_once() {
  for (Load& load : loads) load.iterations = 1;
  increment.resize(residual.rows(), residual.cols());
  borrow(VectorXd::Constant(std::ssize(loads), std::numeric_limits<double>::infinity()));
  precondition(working_.increment);
  give_back();
}

void ThermalIteration::require_done(int limit) const {
  const VectorXd norm = norms(residual);
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const double left = norm[l];
    if (!(left <= loads[l].threshold)) {
      throw core::SolverError(fmt::format(
          "thermal step: load {} of {} has a residual of {:.2e} W where {:.2e} W is allowed, after {} iterations",
          l + 1, loads.size(), left, loads[l].threshold, limit));
    }
  }
}

}  // namespace thermotwin::solver
