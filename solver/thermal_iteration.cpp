// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal_iteration.h"

#include <fmt/format.h>

#include <algorithm>

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

void ThermalIteration::multiply(std::size_t l, const double* x, double* ex, double* kx) const {
  const Load& load = loads[l];
  op.multiply(load.k_values, x, ex, kx);
  if (load.local.empty()) return;
  const Eigen::Map<const VectorXd> of(x, op.size());
  Eigen::Map<VectorXd>(ex, op.size()) += load.local.capacity * of;
  Eigen::Map<VectorXd>(kx, op.size()) += load.local.conduction * of;
}

bool ThermalIteration::set_coefficients(std::size_t l, const VectorXd& p) {
  Load& load = loads[l];
  if (load.k_values.size() > 0 && load.p.size() == p.size() && load.p == p) return false;
  load.p = p;
  op.combine(load.p, load.k_values);
  load.changed = true;
  return true;
}

void ThermalIteration::factorise(Factor& factor, const VectorXd& p, double at_shift) const {
  factor.p = p;
  factor.shift = at_shift;
  VectorXd k_values;
  op.combine(p, k_values);
  factor.solver.factorise(op, k_values, at_shift);
}

std::unique_ptr<ThermalIteration::Factor> ThermalIteration::new_factor() const {
  auto factor = std::make_unique<Factor>();
  if (!factors.empty()) factor->solver.adopt(factors.front()->solver);
  return factor;
}

void ThermalIteration::update_fluid_factors() {
  core::parallel_for(0, loads.size(), [&](std::size_t l) {
    Load& load = loads[l];
    if (load.changed) load.fluids = factors[load.factor]->solver.fluid_factor(op.fluid_block(load.k_values, shift));
    load.changed = false;
  });
}

void ThermalIteration::start(const VectorXd& scale, double tolerance) {
  for (std::size_t l = 0; l < loads.size(); ++l)
    loads[l].threshold = std::max(tolerance * residual.col(static_cast<Index>(l)).norm(), rounding * scale[static_cast<Index>(l)]);
  increment.setZero(residual.rows(), residual.cols());
  capacity_increment.setZero(residual.rows(), residual.cols());
}

/// One GCR step of a load with its preconditioned residual.
void ThermalIteration::gcr_step(std::size_t l, Eigen::Ref<VectorXd> z) {
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
  multiply(l, z.data(), fresh.ez.data(), fresh.az.data());
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

std::size_t ThermalIteration::factor_of(Index active_column) const {
  return loads[active_[static_cast<std::size_t>(active_column)]].factor;
}

bool ThermalIteration::iterate(int limit) {
  for (Load& load : loads) load.iterations = 0;
  for (int i = 0; i <= limit; ++i) {
    active_.clear();
    for (std::size_t l = 0; l < loads.size(); ++l)
      if (!(residual.col(static_cast<Index>(l)).norm() <= loads[l].threshold)) active_.push_back(l);
    if (active_.empty()) return true;
    if (i == limit) return false;
    // Loads of one factor side by side: it is read once for all of them.
    std::stable_sort(active_.begin(), active_.end(), [&](std::size_t a, std::size_t b) { return loads[a].factor < loads[b].factor; });
    const auto count = static_cast<Index>(active_.size());
    packed_.resize(residual.rows(), count);
    preconditioned_.resize(residual.rows(), count);
    for (Index a = 0; a < count; ++a) packed_.col(a) = residual.col(static_cast<Index>(active_[static_cast<std::size_t>(a)]));
    std::vector<Index> first;  // column of each factor's first load, then the end
    for (Index a = 0; a < count; ++a)
      if (a == 0 || factor_of(a) != factor_of(a - 1)) first.push_back(a);
    first.push_back(count);
    core::parallel_for(0, first.size() - 1, [&](std::size_t g) {
      const Index width = first[g + 1] - first[g];
      factors[factor_of(first[g])]->solver.precondition_bodies(packed_.middleCols(first[g], width),
                                                               preconditioned_.middleCols(first[g], width));
    });
    core::parallel_for(0, active_.size(), [&](std::size_t a) { gcr_step(active_[a], preconditioned_.col(static_cast<Index>(a))); });
  }
  return false;
}

void ThermalIteration::require_done(int limit) const {
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const double left = residual.col(static_cast<Index>(l)).norm();
    if (!(left <= loads[l].threshold))
      throw core::SolverError(fmt::format(
          "thermal step: load {} of {} has a residual of {:.2e} W where {:.2e} W is allowed, after {} iterations", l + 1,
          loads.size(), left, loads[l].threshold, limit));
  }
}

}  // namespace thermotwin::solver
