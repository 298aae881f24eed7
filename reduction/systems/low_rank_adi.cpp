// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/low_rank_adi.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/error.h"
#include "core/progress.h"
#include "core/range.h"

namespace thermotwin::reduction {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

double norm_of_gram(const MatrixXd& w) {
  const bool wide = w.cols() > w.rows();
  const MatrixXd gram = wide ? MatrixXd(w * w.transpose()) : MatrixXd(w.transpose() * w);
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(gram, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

/// One of the two equations.
struct Side {
  MatrixXd rest;                 ///< W
  std::vector<MatrixXd> blocks;  ///< of Z
  std::vector<MatrixXd> newest;  ///< V, for the next shifts
  double start = 0, residual = 1;

  explicit Side(MatrixXd right) : rest(std::move(right)), start(norm_of_gram(rest)) {}
  void measure() { residual = norm_of_gram(rest) / start; }
  MatrixXd factor() const {
    Index columns = 0;
    for (const MatrixXd& block : blocks) columns += block.cols();
    MatrixXd z(rest.rows(), columns);
    columns = 0;
    for (const MatrixXd& block : blocks) {
      z.middleCols(columns, block.cols()) = block;
      columns += block.cols();
    }
    return z;
  }
};

/// V = (A + p E)^-1 W, the columns that it adds to Z, the new W.
void advance(Side& side, const ShiftFactor& factor, const Sparse& e, Complex p, bool transposed) {
  const auto times_e = [&](const MatrixXd& v) -> MatrixXd {
    return transposed ? MatrixXd(e.transpose() * v) : MatrixXd(e * v);
  };
  if (p.imag() == 0.0) {
    MatrixXd v = -factor.solve_real(side.rest, transposed);
    side.rest -= 2.0 * p.real() * times_e(v);
    side.blocks.push_back(std::sqrt(-2.0 * p.real()) * v);
    side.newest.push_back(std::move(v));
  } else {
    const MatrixXcd v = -factor.solve(side.rest.cast<Complex>(), transposed);
    const double gamma = 2.0 * std::sqrt(-p.real()), delta = p.real() / p.imag();
    const MatrixXd first = v.real() + delta * v.imag(), second = v.imag();
    side.rest += gamma * gamma * times_e(first);
    side.blocks.push_back(gamma * first);
    side.blocks.push_back(gamma * std::sqrt(delta * delta + 1.0) * second);
    side.newest.push_back(first);
    side.newest.push_back(second);
  }
  side.measure();
}

/// Few columns that stand for many: random sums, so that no input is left out.
MatrixXd thinned(const MatrixXd& columns, Index most, std::mt19937& engine) {
  if (columns.cols() <= most) return columns;
  std::normal_distribution<double> normal;
  const MatrixXd mixture = MatrixXd::NullaryExpr(columns.cols(), most, [&](Index, Index) { return normal(engine); });
  return columns * mixture;
}

MatrixXd orthonormal_range(MatrixXd columns) {
  const Eigen::VectorXd norms = columns.colwise().norm();
  for (Index k = 0; k < columns.cols(); ++k)
    if (norms(k) > 0.0) columns.col(k) /= norms(k);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(MatrixXd(columns.transpose() * columns));
  constexpr double independent = 1e-10;
  const auto rank = (gram.eigenvalues().array() > independent * gram.eigenvalues().maxCoeff()).count();
  const Eigen::VectorXd scale = gram.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse();
  return columns * (gram.eigenvectors().rightCols(rank) * scale.asDiagonal());
}

/// Ritz values in the left half plane, one of each complex pair.
std::vector<Complex> ritz_values(const StateSpace& system, const MatrixXd& columns) {
  const MatrixXd u = orthonormal_range(columns);
  const MatrixXd e = u.transpose() * (system.E * u), a = u.transpose() * (system.A * u);
  std::vector<Complex> values;
  const Eigen::EigenSolver<MatrixXd> pencil(MatrixXd(e.partialPivLu().solve(a)), false);
  if (pencil.info() != Eigen::Success) return values;
  constexpr double nearly_real = 1e-7;
  for (const Complex& value : pencil.eigenvalues()) {
    if (!(value.real() < 0.0) || !std::isfinite(std::abs(value)) || value.imag() < 0.0) continue;
    // A shift on the imaginary axis would not damp anything.
    const Complex shift(std::min(value.real(), -1e-6 * std::abs(value)), value.imag());
    values.push_back(shift.imag() < nearly_real * std::abs(shift) ? Complex(-std::abs(shift), 0) : shift);
  }
  return values;
}

/// Reduction of a mode t by one step with the shift p (and its conjugate).
double damping(Complex t, Complex p) {
  const double one = std::abs((t - std::conj(p)) / (t + p));
  return p.imag() == 0.0 ? one : one * std::abs((t - p) / (t + std::conj(p)));
}

/// The candidates that damp all of them best, the worst mode first (T. Penzl's heuristic).
std::vector<Complex> choose(const std::vector<Complex>& candidates, std::size_t most) {
  std::vector<Complex> chosen;
  if (candidates.empty()) return chosen;
  std::vector<double> left(candidates.size(), 1.0);
  const auto use = [&](Complex p) {
    chosen.push_back(p);
    for (std::size_t i = 0; i < left.size(); ++i) left[i] *= damping(candidates[i], p);
  };
  double best = std::numeric_limits<double>::infinity();
  Complex first = candidates.front();
  for (const Complex& p : candidates) {
    double worst = 0;
    for (const Complex& t : candidates) worst = std::max(worst, damping(t, p));
    if (worst < best) best = worst, first = p;
  }
  use(first);
  while (chosen.size() < std::min(most, candidates.size())) {
    const auto worst = std::max_element(left.begin(), left.end());
    if (*worst == 0.0) break;
    use(candidates[worst - left.begin()]);
  }
  return chosen;
}

MatrixXd newest_columns(std::vector<Side>& sides, Index most, std::mt19937& engine) {
  std::vector<MatrixXd> blocks;
  Index columns = 0;
  // Sides in turn from the newest block back, so that both have their say.
  for (std::size_t back = 0; columns < most; ++back) {
    bool any = false;
    for (Side& side : sides) {
      if (back >= side.newest.size()) continue;
      any = true;
      blocks.push_back(thinned(side.newest[side.newest.size() - 1 - back], 12, engine));
      columns += blocks.back().cols();
    }
    if (!any) break;
  }
  for (Side& side : sides) side.newest.clear();
  MatrixXd all(sides.front().rest.rows(), columns);
  columns = 0;
  for (const MatrixXd& block : blocks) {
    all.middleCols(columns, block.cols()) = block;
    columns += block.cols();
  }
  return all;
}

}  // namespace

void AdiOptions::validate() const {
  core::require_option(residual > 0.0 && residual < 1.0, "low-rank Gramians residual", residual, "above 0, below 1");
  core::require_option(most_steps >= 1, "low-rank Gramians most_steps", most_steps, "1 or more");
}

AdiFactors low_rank_gramians(const StateSpace& system, const Factorise& factorise, const AdiOptions& options) {
  options.validate();
  constexpr std::size_t shifts_at_once = 10;
  constexpr Index widest_projection = 60;
  std::mt19937 engine(1);
  std::vector<Side> sides;
  sides.emplace_back(system.B);
  sides.emplace_back(MatrixXd(system.C.transpose()));

  // Where the inputs act lives the fast part, what they lead to at rest is the slow one.
  const auto at_rest = factorise(0.0);
  for (std::size_t k = 0; k < 2; ++k) {
    const MatrixXd start = thinned(sides[k].rest, 12, engine);
    sides[k].newest = {start, at_rest->solve_real(start, k == 1)};
  }

  AdiFactors result;
  core::Progress progress("low-rank Gramians, digits of the residual",
                          static_cast<std::size_t>(std::ceil(-std::log10(options.residual))));
  int digits = 0;
  std::vector<Complex> shifts;
  std::size_t next = 0;
  while (result.residual = std::max(sides[0].residual, sides[1].residual), result.residual > options.residual) {
    if (result.steps >= options.most_steps || !std::isfinite(result.residual)) {
      throw core::SolverError(
          fmt::format("the low-rank Gramians have a residual of {:.2g} after {} steps, above the tolerance of {:.0e}: "
                      "the system is close to unstable, or its Gramians have no low rank",
                      result.residual, result.steps, options.residual));
    }
    core::check_interrupt();
    if (next == shifts.size()) {
      std::vector<Complex> candidates = ritz_values(system, newest_columns(sides, widest_projection, engine));
      if (!candidates.empty() || shifts.empty()) shifts = choose(candidates, shifts_at_once);
      if (shifts.empty()) {
        throw core::SolverError(
            "low-rank Gramians: no shift in the left half plane was found; the system is far from normal");
      }
      next = 0;
    }
    const Complex p = shifts[next++];
    const auto factor = factorise(-p);
    for (std::size_t k = 0; k < 2; ++k)
      if (sides[k].residual > options.residual) advance(sides[k], *factor, system.E, p, k == 1);
    ++result.steps;
    result.smallest_shift = result.steps == 1 ? std::abs(p) : std::min(result.smallest_shift, std::abs(p));
    result.largest_shift = std::max(result.largest_shift, std::abs(p));
    for (const double now = -std::log10(std::max(sides[0].residual, sides[1].residual)); digits + 1 <= now; ++digits)
      progress.advance();
  }
  result.controllability = sides[0].factor();
  result.observability = sides[1].factor();
  result.controllability_rest = std::move(sides[0].rest);
  result.observability_rest = std::move(sides[1].rest);
  return result;
}

}  // namespace thermotwin::reduction
