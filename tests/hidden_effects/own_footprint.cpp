// SPDX-License-Identifier: GPL-3.0-or-later
#include "own_footprint.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "solver/campaign/full_model.h"
#include "solver/operation/layout.h"
#include "wrong_parts.h"

namespace thermotwin::hidden {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Heat of columns after five minutes of conduction: E (E + 300 s K)^-1 S, the same in sum.
MatrixXd spread_heat(const solver::ThermalSystem& thermal, const solver::Coefficients& c, const MatrixXd& columns) {
  if (columns.cols() == 0) return columns;
  const double shift = 1.0 / 300.0;
  solver::Coefficients closed = c;
  closed.p.setZero();
  return thermal.capacity * (shift * solver::solve_shifted(thermal, closed, shift, columns));
}

solver::SparseMatrix with_columns(const solver::SparseMatrix& matrix, const MatrixXd& more) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index k = 0; k < matrix.outerSize(); ++k) {
    for (solver::SparseMatrix::InnerIterator it(matrix, k); it; ++it)
      entries.emplace_back(it.row(), it.col(), it.value());
  }
  for (Index k = 0; k < more.cols(); ++k) {
    for (Index i = 0; i < more.rows(); ++i)
      if (more(i, k) != 0.0) entries.emplace_back(i, matrix.cols() + k, more(i, k));
  }
  solver::SparseMatrix wider(matrix.rows(), matrix.cols() + more.cols());
  wider.setFromTriplets(entries.begin(), entries.end());
  return wider;
}

}  // namespace

VectorXd unevenness(const solver::FullModel& full, double phase) {
  VectorXd factor = VectorXd::Ones(full.thermal.size);
  for (std::size_t b = 0; b < full.mesh.bodies.size(); ++b) {
    const mesh::TetMesh& body = full.mesh.bodies[b];
    for (Index n = 0; n < body.points.cols(); ++n)
      factor[full.mesh.first_node[b] + n] = 1.0 + 0.2 * std::sin(7.0 * body.points.col(n).sum() + phase);
  }
  return factor;
}

OwnFootprint::OwnFootprint(const solver::FullModel& full, const solver::OperatingModel& right,
                           const solver::OperatingModel& wrong, const std::vector<VectorXd>& rows,
                           const std::vector<const Truth*>& spots, const VectorXd& uneven)
    : thermal_(full.thermal),
      terms_(std::ssize(full.thermal.terms)),
      inputs_(full.thermal.inputs.cols()),
      spots_(std::ssize(spots)),
      input_of_source_(inputs_),
      term_of_film_(terms_),
      input_of_film_(terms_, -1) {
  const VectorXd inlet = VectorXd::Constant(std::ssize(right.machine().coolants), 0.1);
  std::vector<std::pair<solver::Coefficients, solver::Coefficients>> both;
  for (const VectorXd& row : rows) both.emplace_back(right.coefficients(row, inlet), wrong.coefficients(row, inlet));
  const auto differs_ever = [&](const auto& pick) {
    return std::any_of(both.begin(), both.end(),
                       [&](const auto& pair) { return pick(pair.first) != pick(pair.second); });
  };
  std::vector<VectorXd> warm;  // to be spread: sources first, then spots
  for (Index k = 0; k < inputs_; ++k) {
    const bool own = full.thermal.layout.inputs[k].kind == solver::InputKind::source &&
                     differs_ever([&](const solver::Coefficients& c) { return c.q[k]; });
    input_of_source_[k] = own ? inputs_ + std::ssize(warm) : k;
    if (own) warm.push_back(full.thermal.inputs.col(k));
  }
  const Index sources = std::ssize(warm);
  for (const Truth* spot : spots)
    warm.push_back(warm_spot(full, spot->parameter.missing->body, spot->parameter.missing->centre));
  MatrixXd columns(thermal_.size, std::ssize(warm));
  for (Index k = 0; k < columns.cols(); ++k) columns.col(k) = warm[k];
  const MatrixXd heat = spread_heat(full.thermal, both.front().first, columns);

  std::vector<VectorXd> film_inputs;
  const VectorXd ones = VectorXd::Ones(thermal_.size);
  for (Index j = 0; j < terms_; ++j) {
    const std::size_t at = j;
    term_of_film_[at] = j;
    if (full.thermal.layout.terms[at].kind != solver::TermKind::film ||
        !differs_ever([&](const solver::Coefficients& c) { return c.p[j]; }))
      continue;
    term_of_film_[at] = std::ssize(thermal_.terms);
    input_of_film_[at] = inputs_ + sources + std::ssize(film_inputs);
    solver::SparseMatrix matrix = uneven.asDiagonal() * full.thermal.terms[at] * uneven.asDiagonal();
    matrix *= ones.dot(full.thermal.terms[at] * ones) / ones.dot(matrix * ones);
    thermal_.layout.terms.push_back(full.thermal.layout.terms[at]);
    film_inputs.push_back(matrix * ones);
    thermal_.terms.push_back(std::move(matrix));
  }
  MatrixXd added(thermal_.size, columns.cols() + std::ssize(film_inputs));
  added.leftCols(sources) = heat.leftCols(sources);
  for (Index f = 0; f < std::ssize(film_inputs); ++f) added.col(sources + f) = film_inputs[f];
  added.rightCols(spots_) = heat.rightCols(spots_);
  thermal_.inputs = with_columns(full.thermal.inputs, added);
  for (Index a = 0; a < added.cols(); ++a) thermal_.layout.inputs.push_back({solver::InputKind::source, -1, 0, 0, 0});
}

void OwnFootprint::add_capacity(const solver::SparseMatrix& more) {
  thermal_.capacity = solver::SparseMatrix(thermal_.capacity + more);
}

solver::Coefficients OwnFootprint::coefficients(const solver::Coefficients& right, const solver::Coefficients& wrong,
                                                double size, const VectorXd& spot_W) const {
  solver::Coefficients c = right;
  c.p = VectorXd::Zero(std::ssize(thermal_.terms));
  c.q = VectorXd::Zero(thermal_.inputs.cols());
  c.p.head(terms_) = right.p;
  c.q.head(inputs_) = right.q;
  for (Index j = 0; j < terms_; ++j) c.p[term_of_film_[j]] += size * (wrong.p[j] - right.p[j]);
  for (Index k = 0; k < inputs_; ++k) {
    const solver::Input& input = thermal_.layout.inputs[k];
    Index at = input_of_source_[k];
    if (input.kind == solver::InputKind::film_ambient && input_of_film_[input.term] >= 0)
      at = input_of_film_[input.term];
    c.q[at] += size * (wrong.q[k] - right.q[k]);
  }
  c.q.tail(spots_) = spot_W;
  c.occupancy.conservativeResize(c.p.size());
  c.occupancy.tail(c.p.size() - terms_).setOnes();
  return c;
}

}  // namespace thermotwin::hidden
