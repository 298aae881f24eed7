// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/dense_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/progress.h"
#include "core/thread_pool.h"
#include "reduction/linear/lapack.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr std::size_t most_peaks = 300;
/// Rows of B fall by many orders on their way; squares of such small ones would underflow.
constexpr double smallest_row = 1e-100;
constexpr double rounding = std::numeric_limits<double>::epsilon();

/// X := (leading block of S + shift)^-1 X, of as many rows as X has.
template <class Block>
void substitute_back(const MatrixXcd& triangular, Complex shift, Block&& x) {
  for (Index i = x.rows() - 1; i >= 0; --i) {
    x.row(i) /= triangular(i, i) + shift;
    if (i > 0) x.topRows(i).noalias() -= triangular.col(i).head(i) * x.row(i);
  }
}

/// J M^H J with J the exchange of first and last: upper triangular again.
MatrixXcd flipped_adjoint(const MatrixXcd& triangular) {
  return triangular.adjoint().colwise().reverse().rowwise().reverse();
}

void require_stable(const VectorXcd& poles, double size, const std::string& place) {
  Index worst = 0;
  for (Index i = 1; i < poles.size(); ++i)
    if (poles(i).real() > poles(worst).real()) worst = i;
  const double real = poles(worst).real();
  if (real > -rounding * size) refuse_unstable(place, poles(worst), std::abs(real) <= rounding * size);
}

Band band_of(const VectorXcd& poles) {
  const VectorXd sizes = poles.cwiseAbs();
  return {sizes.minCoeff(), sizes.maxCoeff()};
}

/// Solutions with E, its rows and columns scaled by powers of 2 before.
class RegularE {
public:
  RegularE(const StateSpace& system, const std::string& place) : identity_(system.identity) {
    if (identity_) return;
    MatrixXd e(system.E);
    const auto power = [](double size) { return size > 0.0 ? std::exp2(-std::round(std::log2(size))) : 1.0; };
    rows_ = e.cwiseAbs().rowwise().maxCoeff().unaryExpr(power);
    e = rows_.asDiagonal() * e;
    columns_ = e.cwiseAbs().colwise().maxCoeff().transpose().unaryExpr(power);
    e = e * columns_.asDiagonal();
    lu_.compute(e);
    const VectorXd pivots = lu_.matrixLU().diagonal().cwiseAbs();
    const double smallest = pivots.minCoeff() / pivots.maxCoeff(),
                 rcond = smallest > 0.0 ? std::min(smallest, lu_.rcond()) : 0.0;
    constexpr double singular = 1e-15, doubtful = 1e-10;
    if (!(rcond > singular)) refuse_singular(place, system.E, rcond);
    if (rcond < doubtful) core::warn(place + "/E.mtx is close to singular: digits are lost");
  }
  MatrixXd solve(const MatrixXd& b) const {
    return identity_ ? b : MatrixXd(columns_.asDiagonal() * lu_.solve(rows_.asDiagonal() * b));
  }
  MatrixXd solve_transposed(const MatrixXd& b) const {
    if (identity_) return b;
    const MatrixXd x = lu_.transpose().solve(columns_.asDiagonal() * b);
    return rows_.asDiagonal() * x;
  }

private:
  bool identity_;
  VectorXd rows_, columns_;
  Eigen::PartialPivLU<MatrixXd> lu_;
};

/// Real and imaginary part as two right-hand sides of a real solve.
template <class Solve>
MatrixXcd in_parts(const MatrixXcd& b, const Solve& solve) {
  const MatrixXd real = solve(b.real()), imaginary = solve(b.imag());
  return real.cast<Complex>() + Complex(0, 1) * imaginary.cast<Complex>();
}

class GeneralDense final : public SystemSolver {
public:
  GeneralDense(const StateSpace& system, const std::string& place) : e_(system, place) {
    MatrixXd a = e_.solve(MatrixXd(system.A));
    scale_ = lapack::balance(a);
    lapack::Schur schur = lapack::schur(std::move(a));
    s_ = std::move(schur.triangular);
    q_ = std::move(schur.vectors);
    norm_ = s_.norm();
    require_stable(s_.diagonal(), norm_, place);
    flipped_ = flipped_adjoint(s_);
    b_ = q_.adjoint() * (scale_.cwiseInverse().asDiagonal() * e_.solve(system.B)).cast<Complex>();
    c_ = (system.C * scale_.asDiagonal()).cast<Complex>() * q_;
  }

  bool dense() const override { return true; }
  bool proved_stable() const override { return true; }
  Band band() const override { return band_of(s_.diagonal()); }
  std::vector<double> peaks() const override { return peak_frequencies(s_.diagonal(), most_peaks); }

  TwoSided solve(Complex s, const MatrixXcd& r, const MatrixXcd& l) const override {
    MatrixXcd right = in_parts(r, [&](const MatrixXd& part) { return e_.solve(part); });
    right = q_.adjoint() * (scale_.cwiseInverse().asDiagonal() * right);
    right = scale_.asDiagonal() * (q_ * inverse_times(s, std::move(right)));
    // conj((s - S)^T) = J (conj(s) - flipped) J.
    MatrixXcd left = (q_.adjoint() * (scale_.asDiagonal() * l).conjugate()).colwise().reverse();
    substitute_back(flipped_, -std::conj(s), left);
    left = -(q_ * left.colwise().reverse()).conjugate();
    left = scale_.cwiseInverse().asDiagonal() * left;
    return {std::move(right), in_parts(left, [&](const MatrixXd& part) { return e_.solve_transposed(part); })};
  }
  MatrixXcd response(Complex s) const override { return c_ * inverse_times(s, b_); }

  GramianFactors gramians() const override {
    MatrixXd factors[2];
    core::parallel_for(0, 2, [&](std::size_t side) {
      MatrixXcd factor =
          side == 0 ? lyapunov_factor(s_, b_) : lyapunov_factor(flipped_, c_.adjoint().colwise().reverse());
      const Index n = s_.rows();
      // In the balanced coordinates; the Gramian is real, so real and imaginary part side by side do.
      if (side == 1) factor = factor.colwise().reverse().eval();
      MatrixXcd z(n, n);
      z.noalias() = q_ * factor;
      factors[side].resize(2 * n, n);
      factors[side] << z.real().transpose(), z.imag().transpose();
    });
    for (MatrixXd& factor : factors) factor = lapack::triangle_of_qr(std::move(factor));
    GramianFactors result;
    result.core = lapack::product(factors[1], MatrixXd(factors[0].transpose()));
    result.controllability = scale_.asDiagonal() * factors[0].transpose();
    result.observability = e_.solve_transposed(scale_.cwiseInverse().asDiagonal() * factors[1].transpose());
    return result;
  }

  Modes dominant_modes(Index count) const override {
    const Index n = s_.rows();
    VectorXd dominance(n);
    core::parallel_for(0, n, [&](std::size_t i) {
      const Index k = i;
      VectorXcd right = right_vector(s_, k), left = left_vector(k);
      left /= std::conj(left.dot(right));
      dominance(k) = (c_ * right).norm() * (left.adjoint() * b_).norm() / std::abs(s_(k, k).real());
    });
    const std::vector<Index> chosen = by_dominance(s_.diagonal(), dominance, count);
    Modes modes{VectorXcd(chosen.size()), MatrixXcd(n, chosen.size()), MatrixXcd(n, chosen.size())};
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const Index k = i;
      const VectorXcd right = right_vector(s_, chosen[i]);
      VectorXcd left = left_vector(chosen[i]);
      left /= std::conj(left.dot(right));
      modes.values(k) = s_(chosen[i], chosen[i]);
      modes.right.col(k) = scale_.asDiagonal() * (q_ * right);
      modes.left.col(k) = scale_.cwiseInverse().asDiagonal() * (q_ * left).conjugate();
    }
    modes.left = in_parts(modes.left, [&](const MatrixXd& part) { return e_.solve_transposed(part); });
    return modes;
  }

private:
  MatrixXcd inverse_times(Complex s, MatrixXcd x) const {
    substitute_back(s_, -s, x);
    return -x;
  }
  VectorXcd right_vector(const MatrixXcd& triangular, Index k) const {
    VectorXcd x = VectorXcd::Zero(triangular.rows());
    x(k) = 1.0;
    x.head(k) = -triangular.col(k).head(k);
    const double smallest = rounding * norm_;
    for (Index i = k - 1; i >= 0; --i) {
      Complex pivot = triangular(i, i) - triangular(k, k);
      if (std::abs(pivot) < smallest) pivot = smallest;
      x(i) /= pivot;
      x.head(i).noalias() -= x(i) * triangular.col(i).head(i);
    }
    return x / x.norm();
  }
  VectorXcd left_vector(Index k) const { return right_vector(flipped_, s_.rows() - 1 - k).reverse(); }

  RegularE e_;
  VectorXd scale_;
  MatrixXcd s_, flipped_, q_, b_, c_;
  double norm_ = 0;
};

class SymmetricDense final : public SystemSolver {
public:
  SymmetricDense(const StateSpace& system, const std::string& place) {
    // E x = -A x / |value|: the slow modes, which matter, come to full digits.
    auto pair = lapack::symmetric_pair(MatrixXd(system.E), -MatrixXd(system.A));
    if (pair && pair->values.minCoeff() > 0.0) {
      values_ = -pair->values.cwiseInverse();
      vectors_ = pair->vectors * pair->values.cwiseSqrt().cwiseInverse().asDiagonal();
    } else {
      pair = lapack::symmetric_pair(MatrixXd(system.A), MatrixXd(system.E));
      if (!pair) refuse_singular(place, system.E, rounding);
      values_ = std::move(pair->values);
      vectors_ = std::move(pair->vectors);
    }
    require_stable(values_.cast<Complex>(), values_.norm(), place);
    b_ = vectors_.transpose() * system.B;
    c_ = system.C * vectors_;
  }

  bool dense() const override { return true; }
  bool proved_stable() const override { return true; }
  Band band() const override { return band_of(values_.cast<Complex>()); }
  std::vector<double> peaks() const override { return {}; }

  TwoSided solve(Complex s, const MatrixXcd& r, const MatrixXcd& l) const override {
    return {solve_one(s, r), solve_one(s, l)};
  }
  MatrixXcd response(Complex s) const override { return c_ * (inverse(s).asDiagonal() * b_.cast<Complex>()); }

  GramianFactors gramians() const override {
    MatrixXd factors[2];
    core::parallel_for(0, 2, [&](std::size_t side) {
      factors[side] = lyapunov_factor(values_, side == 0 ? b_ : MatrixXd(c_.transpose()));
    });
    GramianFactors result;
    result.core = lapack::product(MatrixXd(factors[1].transpose()), factors[0]);
    result.controllability = lapack::product(vectors_, factors[0]);
    result.observability = lapack::product(vectors_, factors[1]);
    return result;
  }

  Modes dominant_modes(Index count) const override {
    const VectorXd dominance =
        c_.colwise().norm().transpose().array() * b_.rowwise().norm().array() / values_.array().abs();
    const std::vector<Index> chosen = by_dominance(values_.cast<Complex>(), dominance, count);
    Modes modes{VectorXcd(chosen.size()), MatrixXcd(vectors_.rows(), chosen.size()), {}};
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      modes.values(i) = values_(chosen[i]);
      modes.right.col(i) = vectors_.col(chosen[i]).cast<Complex>();
    }
    modes.left = modes.right;
    return modes;
  }

private:
  MatrixXcd solve_one(Complex s, const MatrixXcd& b) const {
    return vectors_ * (inverse(s).asDiagonal() * (vectors_.transpose() * b));
  }
  VectorXcd inverse(Complex s) const { return (s - values_.cast<Complex>().array()).inverse().matrix(); }

  VectorXd values_;
  MatrixXd vectors_, b_, c_;
};

/// Whether the symmetric eigenproblem may be posed: E well away from singular.
bool positive_definite(const Sparse& e) {
  const VectorXd diagonal = e.diagonal();
  if ((diagonal.array() <= 0.0).any()) return false;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatrixXd> llt(scale.asDiagonal() * MatrixXd(e) * scale.asDiagonal());
  constexpr double regular = 1e-13;
  return llt.info() == Eigen::Success && llt.rcond() > regular;
}

}  // namespace

MatrixXcd lyapunov_factor(const MatrixXcd& triangular, MatrixXcd input) {
  const Index n = triangular.rows();
  const double nothing = smallest_row * input.norm();
  MatrixXcd u = MatrixXcd::Zero(n, n);
  for (Index k = n - 1; k >= 0; --k) {
    const double size = input.row(k).norm();
    if (size <= nothing) continue;  // nothing of B is left in this row: the column is zero
    const Complex pole = triangular(k, k);
    u(k, k) = size / std::sqrt(-2.0 * pole.real());
    const Eigen::RowVectorXcd beta = input.row(k) / u(k, k);
    if (k == 0) break;
    auto column = u.col(k).head(k);
    column = -triangular.col(k).head(k) * u(k, k) - input.topRows(k) * beta.adjoint();
    substitute_back(triangular, std::conj(pole), column);
    input.topRows(k).noalias() -= column * beta;
  }
  return u;
}

MatrixXd lyapunov_factor(const VectorXd& diagonal, MatrixXd input) {
  const Index n = diagonal.size();
  const double nothing = smallest_row * input.norm();
  MatrixXd u = MatrixXd::Zero(n, n);
  for (Index k = n - 1; k >= 0; --k) {
    const double size = input.row(k).norm();
    if (size <= nothing) continue;
    u(k, k) = size / std::sqrt(-2.0 * diagonal(k));
    const Eigen::RowVectorXd beta = input.row(k) / u(k, k);
    if (k == 0) break;
    auto column = u.col(k).head(k);
    column = -(input.topRows(k) * beta.transpose()).array() / (diagonal.head(k).array() + diagonal(k));
    input.topRows(k).noalias() -= column * beta;
  }
  return u;
}

std::unique_ptr<SystemSolver> make_dense_solver(const StateSpace& system, const std::string& place) {
  if (system.symmetric && (system.identity || positive_definite(system.E)))
    return std::make_unique<SymmetricDense>(system, place);
  return std::make_unique<GeneralDense>(system, place);
}

}  // namespace thermotwin::reduction
