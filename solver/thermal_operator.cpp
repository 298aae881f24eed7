// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal_operator.h"

#include <algorithm>

#include "core/thread_pool.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int few_columns = 16;  // the factor is read once for all of them

template <class Visit>
void visit_entries(const SparseMatrix& matrix, const Visit& visit) {
  for (int column = 0; column < matrix.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it)
      visit(static_cast<int>(it.row()), column, it.value());
}

}  // namespace

ThermalOperator::ThermalOperator(const ThermalSystem& system) : system_(system) {
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(system.size));
  const auto note = [&](int row, int column, double) {
    rows[static_cast<std::size_t>(row)].push_back(column);
    rows[static_cast<std::size_t>(column)].push_back(row);
  };
  visit_entries(system.capacity, note);
  visit_entries(system.conduction, note);
  for (const SparseMatrix& term : system.terms) visit_entries(term, note);

  outer_.push_back(0);
  body_outer_.push_back(0);
  for (Index row = 0; row < system.size; ++row) {
    std::vector<int>& columns = rows[static_cast<std::size_t>(row)];
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    for (int column : columns) {
      if (row < system.nodes && column < system.nodes) {
        body_inner_.push_back(column);
        body_places_.push_back(static_cast<int>(inner_.size()));
      }
      inner_.push_back(column);
    }
    if (row < system.nodes) body_outer_.push_back(static_cast<int>(body_inner_.size()));
    outer_.push_back(static_cast<int>(inner_.size()));
    std::vector<int>().swap(columns);
  }

  const auto place = [&](int row, int column) {
    const auto first = inner_.begin() + outer_[static_cast<std::size_t>(row)];
    const auto last = inner_.begin() + outer_[static_cast<std::size_t>(row) + 1];
    return static_cast<int>(std::lower_bound(first, last, column) - inner_.begin());
  };
  e_values_.setZero(static_cast<Index>(inner_.size()));
  k0_values_.setZero(static_cast<Index>(inner_.size()));
  visit_entries(system.capacity, [&](int r, int c, double v) { e_values_[place(r, c)] += v; });
  visit_entries(system.conduction, [&](int r, int c, double v) { k0_values_[place(r, c)] += v; });
  for (const SparseMatrix& term : system.terms) {
    std::vector<int> places;
    places.reserve(static_cast<std::size_t>(term.nonZeros()));
    visit_entries(term, [&](int r, int c, double) { places.push_back(place(r, c)); });
    places_.push_back(std::move(places));
  }
}

void ThermalOperator::combine(const VectorXd& p, VectorXd& k_values) const {
  k_values = k0_values_;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const double coefficient = p[static_cast<Index>(t)];
    if (coefficient == 0.0) continue;
    const double* values = system_.terms[t].valuePtr();
    const std::vector<int>& places = places_[t];
    for (std::size_t i = 0; i < places.size(); ++i) k_values[places[i]] += coefficient * values[i];
  }
}

void ThermalOperator::multiply(const VectorXd& k_values, const double* x, double* ex, double* kx) const {
  constexpr std::size_t rows_at_once = 4096;
  const auto n = static_cast<std::size_t>(size());
  const double *e = e_values_.data(), *k = k_values.data();
  const auto rows = [&](std::size_t block) {
    const std::size_t last = std::min(n, (block + 1) * rows_at_once);
    for (std::size_t row = block * rows_at_once; row < last; ++row) {
      double sum_e = 0.0, sum_k = 0.0;
      for (int i = outer_[row]; i < outer_[row + 1]; ++i) {
        const double value = x[inner_[static_cast<std::size_t>(i)]];
        sum_e += e[i] * value;
        sum_k += k[i] * value;
      }
      ex[row] = sum_e;
      kx[row] = sum_k;
    }
  };
  core::parallel_for(0, (n + rows_at_once - 1) / rows_at_once, rows);
}

void ThermalOperator::body_block(const VectorXd& k_values, double shift, SparseMatrix& block) const {
  if (block.cols() != nodes()) {
    const std::vector<double> zeros(body_inner_.size(), 0.0);
    block = Eigen::Map<const SparseMatrix>(nodes(), nodes(), static_cast<Index>(body_inner_.size()), body_outer_.data(),
                                           body_inner_.data(), zeros.data());
    block.makeCompressed();
  }
  // Symmetric: its rows are its columns.
  for (std::size_t i = 0; i < body_places_.size(); ++i)
    block.valuePtr()[i] = shift * e_values_[body_places_[i]] + k_values[body_places_[i]];
}

MatrixXd ThermalOperator::fluid_block(const VectorXd& k_values, double shift) const {
  MatrixXd block = MatrixXd::Zero(fluids(), fluids());
  for (Index row = nodes(); row < size(); ++row)
    for (int i = outer_[static_cast<std::size_t>(row)]; i < outer_[static_cast<std::size_t>(row) + 1]; ++i)
      if (const Index column = inner_[static_cast<std::size_t>(i)] - nodes(); column >= 0)
        block(row - nodes(), column) = shift * e_values_[i] + k_values[i];
  return block;
}

MatrixXd ThermalOperator::coupling(const VectorXd& k_values) const {
  MatrixXd block = MatrixXd::Zero(nodes(), fluids());
  for (Index row = nodes(); row < size(); ++row)
    for (int i = outer_[static_cast<std::size_t>(row)]; i < outer_[static_cast<std::size_t>(row) + 1]; ++i)
      if (const int column = inner_[static_cast<std::size_t>(i)]; column < nodes()) block(column, row - nodes()) = k_values[i];
  return block;
}

void BlockSolver::factorise(const ThermalOperator& op, const VectorXd& k_values, double shift) {
  nodes_ = op.nodes();
  op.body_block(k_values, shift, block_);
  if (factor_) {
    factor_->factorise(block_);
  } else {
    SparseFactorOptions options;
    options.columns_at_once = few_columns;
    factor_.emplace(block_, options);
  }
  coupling_ = op.coupling(k_values);
  solved_ = factor_->solve(coupling_);
  own_ = fluid_factor(op.fluid_block(k_values, shift));
}

BlockSolver::FluidFactor BlockSolver::fluid_factor(const MatrixXd& fluid_block) const {
  if (fluid_block.size() == 0) return {};
  return FluidFactor(fluid_block - coupling_.transpose() * solved_);
}

void BlockSolver::solve_bodies(const Eigen::Ref<const MatrixXd>& b, Eigen::Ref<MatrixXd> x) const {
  factor_->solve(b.topRows(nodes_), x.topRows(nodes_));
  x.bottomRows(x.rows() - nodes_) = b.bottomRows(b.rows() - nodes_);
}

void BlockSolver::finish(Eigen::Ref<VectorXd> x, const FluidFactor& fluids, bool transpose) const {
  const Index count = x.size() - nodes_;
  if (count == 0) return;
  const VectorXd right = x.tail(count) - coupling_.transpose() * x.head(nodes_);
  const VectorXd fluid = transpose ? VectorXd(fluids.transpose().solve(right)) : VectorXd(fluids.solve(right));
  x.tail(count) = fluid;
  x.head(nodes_) -= solved_ * fluid;
}

}  // namespace thermotwin::solver
