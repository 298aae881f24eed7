// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/terms.h"

#include <Eigen/QR>

#include <algorithm>
#include <iterator>

#include "core/thread_pool.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of the largest: what is smaller in U at a term's nodes is not kept. A bound's sums round to far more
/// (error_bound.cpp).
constexpr double kept_direction = 1e-11;

/// Rows and columns with an entry.
std::vector<Index> nodes_of(const solver::SparseMatrix& term) {
  std::vector<bool> touched(term.rows(), false);
  for (int column = 0; column < term.outerSize(); ++column) {
    for (solver::SparseMatrix::InnerIterator entry(term, column); entry; ++entry)
      if (entry.value() != 0.0) touched[entry.row()] = touched[column] = true;
  }
  std::vector<Index> nodes;
  for (std::size_t i = 0; i < touched.size(); ++i)
    if (touched[i]) nodes.push_back(i);
  return nodes;
}

/// The term among its own nodes.
solver::SparseMatrix among(const solver::SparseMatrix& term, const std::vector<Index>& nodes) {
  std::vector<int> place(term.rows(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) place[nodes[i]] = i;
  std::vector<Eigen::Triplet<double>> entries;
  for (const Index column : nodes) {
    for (solver::SparseMatrix::InnerIterator entry(term, column); entry; ++entry)
      if (entry.value() != 0.0) entries.emplace_back(place[entry.row()], place[column], entry.value());
  }
  solver::SparseMatrix small(std::ssize(nodes), std::ssize(nodes));
  small.setFromTriplets(entries.begin(), entries.end());
  return small;
}

struct Factors {
  MatrixXd left, right;
};

/// U at the nodes is Q R with few rows of R; K U = (K Q) R.
Factors factors_of(const solver::SparseMatrix& term, const MatrixXd& u, const RowMajorMatrix& probes,
                   const MatrixXd& stored) {
  const std::vector<Index> nodes = nodes_of(term);
  if (nodes.empty()) return {MatrixXd(u.cols() + probes.cols(), 0), MatrixXd(u.cols(), 0)};
  const MatrixXd here = u(nodes, Eigen::all);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(here);
  qr.setThreshold(kept_direction);
  const Index rank = qr.rank();
  const MatrixXd directions = among(term, nodes) * (qr.householderQ() * MatrixXd::Identity(here.rows(), rank));
  Factors result;
  result.right = qr.colsPermutation() * MatrixXd(qr.matrixR().topRows(rank).triangularView<Eigen::Upper>()).transpose();
  result.left.resize(u.cols() + probes.cols(), rank);
  result.left.topRows(u.cols()).noalias() = here.transpose() * directions;
  result.left.bottomRows(probes.cols()).noalias() = stored * result.left.topRows(u.cols());
  result.left.bottomRows(probes.cols()).noalias() -= MatrixXd(probes(nodes, Eigen::all)).transpose() * directions;
  return result;
}

}  // namespace

BoundTerms bound_terms(const solver::ThermalSystem& thermal, const MatrixXd& u, Index dual,
                       const RowMajorMatrix& probes, const MatrixXd& stored) {
  const RowMajorMatrix trial = u;
  const Index m = u.cols(), count = std::ssize(thermal.terms);
  BoundTerms terms;
  terms.base.resize(m + probes.cols(), m);
  terms.base.topRows(m) = project(thermal.conduction, trial);
  terms.base.bottomRows(probes.cols()) = stored * terms.base.topRows(m) - project(thermal.conduction, probes, trial);
  terms.stored = stored.rightCols(m - dual);
  std::vector<Factors> factors(count);
  core::parallel_for(0, factors.size(),
                     [&](std::size_t j) { factors[j] = factors_of(thermal.terms[j], u, probes, stored); });
  terms.first.assign(1, 0);
  for (const Factors& f : factors) terms.first.push_back(terms.first.back() + f.right.cols());
  terms.left.resize(m + probes.cols(), terms.first.back());
  terms.right.resize(m, terms.first.back());
  for (std::size_t j = 0; j < factors.size(); ++j) {
    terms.left.middleCols(terms.first[j], factors[j].left.cols()) = factors[j].left;
    terms.right.middleCols(terms.first[j], factors[j].right.cols()) = factors[j].right;
    factors[j] = {};
  }
  return terms;
}

BoundSum::BoundSum(const BoundTerms& terms) : terms_(terms), p_(VectorXd::Zero(terms.count())), sum_(terms.base) {}

void BoundSum::set(const VectorXd& p) {
  for (Index j = 0; j < p.size(); ++j) {
    if (p(j) == p_(j)) continue;
    const Index first = terms_.first[j], rank = terms_.first[j + 1] - first;
    if (rank > 0) {
      sum_.noalias() +=
          ((p(j) - p_(j)) * terms_.left.middleCols(first, rank)) * terms_.right.middleCols(first, rank).transpose();
    }
    p_(j) = p(j);
  }
}

MatrixXd BoundSum::dual_residual() const {
  const Index m = terms_.order(), d = terms_.dual();
  // What K leaves on U less what U's other columns take of it: G^T (E W W^T K W - K W), K = K^T. A flow goes from one
  // fluid node to the next and W has each of them, so that neither it nor its transpose leaves anything.
  return residual().leftCols(d) - terms_.stored * conduction().block(d, 0, m - d, d);
}

}  // namespace thermotwin::reduction
