// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/operator.h"

#include <algorithm>
#include <iterator>

#include "core/thread_pool.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int few_columns = 16;           // the factor is read once for all of them
constexpr double body_tolerance = 1e-11;  // of a solve by multigrid that counts as exact

template <class Visit>
void visit_entries(const SparseMatrix& matrix, const Visit& visit) {
  for (int column = 0; column < matrix.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) visit(it.row(), column, it.value());
}

}  // namespace

ThermalOperator::ThermalOperator(const ThermalSystem& system) : system_(system) {
  const std::size_t size = system.size;
  const auto sort = [](std::vector<int>& columns) {
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  };
  const auto place = [](const std::vector<int>& outer, const std::vector<int>& inner, int row, int column) -> int {
    const auto first = inner.begin() + outer[row], last = inner.begin() + outer[row + 1];
    return std::lower_bound(first, last, column) - inner.begin();
  };

  std::vector<std::vector<int>> rows(size);
  const auto note = [&](int row, int column, double) { rows[row].push_back(column); };
  visit_entries(system.capacity, note);
  visit_entries(system.conduction, note);
  outer_.push_back(0);
  for (std::vector<int>& columns : rows) {
    sort(columns);
    inner_.insert(inner_.end(), columns.begin(), columns.end());
    outer_.push_back(inner_.size());
  }
  e_.assign(inner_.size(), 0.0);
  k_.assign(inner_.size(), 0.0);
  visit_entries(system.capacity, [&](int r, int c, double v) { e_[place(outer_, inner_, r, c)] += v; });
  visit_entries(system.conduction, [&](int r, int c, double v) { k_[place(outer_, inner_, r, c)] += v; });

  // Terms by rows; a row has a term's entries next to each other since terms come one after the other.
  std::vector<int> next(size + 1, 0);
  for (const SparseMatrix& term : system.terms) visit_entries(term, [&](int r, int, double) { ++next[r + 1]; });
  for (std::size_t r = 0; r < size; ++r) next[r + 1] += next[r];
  term_inner_.resize(next.back());
  term_values_.resize(term_inner_.size());
  std::vector<int> of_term(term_inner_.size());
  const std::vector<int> first = next;
  for (std::size_t t = 0; t < system.terms.size(); ++t) {
    visit_entries(system.terms[t], [&](int r, int c, double v) {
      const std::size_t at = next[r]++;
      term_inner_[at] = c;
      term_values_[at] = v;
      of_term[at] = t;
    });
  }
  for (std::size_t r = 0; r < size; ++r) {
    segment_outer_.push_back(segments_.size());
    for (int i = first[r]; i < first[r + 1]; ++i)
      if (i == first[r] || of_term[i] != of_term[i - 1]) segments_.push_back({of_term[i], i});
  }
  segment_outer_.push_back(segments_.size());
  segments_.push_back({-1, first.back()});

  // Body block, symmetric: its rows are its columns.
  for (const SparseMatrix& term : system.terms) {
    visit_entries(term, [&](int r, int c, double) {
      rows[r].push_back(c);
      rows[c].push_back(r);
    });
  }
  const int nodes = system.nodes;
  body_outer_.push_back(0);
  for (int row = 0; row < nodes; ++row) {
    std::vector<int>& columns = rows[row];
    sort(columns);
    body_inner_.insert(body_inner_.end(), columns.begin(), std::lower_bound(columns.begin(), columns.end(), nodes));
    body_outer_.push_back(body_inner_.size());
    std::vector<int>().swap(columns);
  }
  const auto in_body = [&](int r, int c) {
    return r < nodes && c < nodes ? place(body_outer_, body_inner_, r, c) : -1;
  };
  for (int row = 0; row < system.size; ++row)
    for (int i = outer_[row]; i < outer_[row + 1]; ++i) volume_places_.push_back(in_body(row, inner_[i]));
  for (const SparseMatrix& term : system.terms) {
    std::vector<int> places;
    places.reserve(term.nonZeros());
    visit_entries(term, [&](int r, int c, double) { places.push_back(in_body(r, c)); });
    term_places_.push_back(std::move(places));
  }
}

template <ThermalOperator::Wanted wanted>
void ThermalOperator::multiply_rows(const SideBySide& p, double shift, const SideBySide& x, double* e,
                                    double* k) const {
  constexpr bool conduct = wanted != Wanted::capacity;
  std::vector<char> used(system_.terms.size());
  if constexpr (conduct)
    for (std::size_t t = 0; t < used.size(); ++t) used[t] = (p.row(t).array() != 0.0).any();
  const Index stride = x.cols();
  over_columns(stride, [&](auto width, Index begin) {
    constexpr int w = decltype(width)::value;
    const double *from = x.data() + begin, *coefficients = p.data() + begin;
    over_rows(
        size(),
        [&](Index first, Index last) {
          for (Index row = first; row < last; ++row) {
            RowSum<w> stored, conducted;
            const std::size_t r = row;
            for (Index i = outer_[r]; i < outer_[r + 1]; ++i) {
              const double* value = from + inner_[i] * stride;
              if constexpr (wanted == Wanted::sum) {
                conducted.add(shift * e_[i] + k_[i], value);
              } else {
                stored.add(e_[i], value);
                if constexpr (conduct) conducted.add(k_[i], value);
              }
            }
            if constexpr (conduct) {
              for (Index s = segment_outer_[r]; s < segment_outer_[r + 1]; ++s) {
                const int term = segments_[s].term;
                if (!used[term]) continue;
                RowSum<w> of_term;
                for (Index i = segments_[s].begin; i < segments_[s + 1].begin; ++i)
                  of_term.add(term_values_[i], from + term_inner_[i] * stride);
                conducted.add(coefficients + term * stride, of_term);
              }
            }
            if constexpr (wanted == Wanted::both) conducted.add(shift, stored);
            if constexpr (wanted != Wanted::sum) stored.put(e + row * stride + begin);
            if constexpr (conduct) conducted.put(k + row * stride + begin);
          }
        },
        1024);
  });
}

void ThermalOperator::multiply(const SideBySide& p, const SideBySide& x, SideBySide& ex, SideBySide& kx) const {
  multiply_shifted(p, 0.0, x, &ex, kx);
}

void ThermalOperator::multiply_shifted(const SideBySide& p, double shift, const SideBySide& x, SideBySide* ex,
                                       SideBySide& ax) const {
  ax.resize(x.rows(), x.cols());
  if (ex == nullptr) return multiply_rows<Wanted::sum>(p, shift, x, nullptr, ax.data());
  ex->resize(x.rows(), x.cols());
  multiply_rows<Wanted::both>(p, shift, x, ex->data(), ax.data());
}

void ThermalOperator::multiply_capacity(const SideBySide& x, SideBySide& ex) const {
  ex.resize(x.rows(), x.cols());
  multiply_rows<Wanted::capacity>(x, 0.0, x, ex.data(), nullptr);
}

void ThermalOperator::body_block(const VectorXd& p, double shift, SparseMatrix& block) const {
  if (block.cols() != nodes() || block.nonZeros() != std::ssize(body_inner_)) {
    const std::vector<double> zeros(body_inner_.size(), 0.0);
    block = Eigen::Map<const SparseMatrix>(nodes(), nodes(), std::ssize(body_inner_), body_outer_.data(),
                                           body_inner_.data(), zeros.data());
    block.makeCompressed();
  }
  double* values = block.valuePtr();
  std::fill_n(values, block.nonZeros(), 0.0);
  for (std::size_t i = 0; i < volume_places_.size(); ++i)
    if (volume_places_[i] >= 0) values[volume_places_[i]] = shift * e_[i] + k_[i];
  for (std::size_t t = 0; t < term_places_.size(); ++t) {
    const double coefficient = p[t];
    if (coefficient == 0.0) continue;
    const double* of_term = system_.terms[t].valuePtr();
    const std::vector<int>& places = term_places_[t];
    for (std::size_t i = 0; i < places.size(); ++i)
      if (places[i] >= 0) values[places[i]] += coefficient * of_term[i];
  }
}

template <class Visit>
void ThermalOperator::visit_row(Index row, const VectorXd& p, const Visit& visit) const {
  const std::size_t r = row;
  for (Index i = outer_[r]; i < outer_[r + 1]; ++i) visit(inner_[i], e_[i], k_[i]);
  for (Index s = segment_outer_[r]; s < segment_outer_[r + 1]; ++s) {
    for (Index i = segments_[s].begin; i < segments_[s + 1].begin; ++i)
      visit(term_inner_[i], 0.0, p[segments_[s].term] * term_values_[i]);
  }
}

MatrixXd ThermalOperator::fluid_block(const VectorXd& p, double shift) const {
  MatrixXd block = MatrixXd::Zero(fluids(), fluids());
  for (Index row = nodes(); row < size(); ++row) {
    visit_row(row, p, [&](Index column, double e, double k) {
      if (column >= nodes()) block(row - nodes(), column - nodes()) += shift * e + k;
    });
  }
  return block;
}

SparseMatrix ThermalOperator::coupling(const VectorXd& p) const {
  std::vector<Eigen::Triplet<double, int>> entries;
  for (Index row = nodes(); row < size(); ++row) {
    visit_row(row, p, [&](Index column, double, double k) {
      if (column < nodes()) entries.emplace_back(column, row - nodes(), k);
    });
  }
  SparseMatrix block(nodes(), fluids());
  block.setFromTriplets(entries.begin(), entries.end());
  return block;
}

void BlockSolver::factorise(const ThermalOperator& op, const VectorXd& p, double shift, bool single_precision) {
  nodes_ = op.nodes();
  op.body_block(p, shift, block_);
  if (factor_) {
    factor_->factorise(block_);
  } else {
    SpdOptions options;
    options.kind = op.system().solver;
    options.factor.columns_at_once = few_columns;
    options.factor.single_precision = single_precision;
    options.multigrid.tolerance = body_tolerance;
    factor_.emplace(block_, options);
  }
  coupling_ = op.coupling(p);
  solved_ = factor_->solve(MatrixXd(coupling_));
  own_ = fluid_factor(op.fluid_block(p, shift));
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

void BlockSolver::precondition(const Eigen::Ref<const SideBySide>& b, Eigen::Ref<SideBySide> x,
                               const std::vector<const FluidFactor*>& fluids) const {
  factor_->precondition(b.topRows(nodes_), x.topRows(nodes_));
  const Index count = x.rows() - nodes_;
  if (count == 0) return;
  SideBySide right = b.bottomRows(count);
  for (int column = 0; column < coupling_.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(coupling_, column); it; ++it) right.row(column) -= it.value() * x.row(it.row());
  for (Index l = 0; l < x.cols(); ++l) {
    const VectorXd of_load = right.col(l);
    right.col(l) = fluids[l]->solve(of_load);
  }
  x.bottomRows(count) = right;
  over_rows(nodes_, [&](Index first, Index last) {
    x.middleRows(first, last - first).noalias() -= solved_.middleRows(first, last - first).lazyProduct(right);
  });
}

}  // namespace thermotwin::solver
