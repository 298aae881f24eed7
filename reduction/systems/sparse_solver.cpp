// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/sparse_solver.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.h"
#include "reduction/linear/arnoldi.h"
#include "reduction/systems/low_rank_adi.h"
#include "reduction/systems/sparse_lu.h"
#include "solver/linear/sparse_factor.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using solver::SparseFactor;

constexpr double singular = 1e-15;

VectorXd random_vector(Index n) {
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  return VectorXd::NullaryExpr(n, [&](Index) { return normal(engine); });
}

/// The factor of a matrix that is symmetric positive definite, nothing for another.
std::unique_ptr<SparseFactor> definite_factor(const Sparse& matrix) {
  if ((VectorXd(matrix.diagonal()).array() <= 0.0).any()) return nullptr;
  try {
    auto factor = std::make_unique<SparseFactor>(matrix);
    return factor->rcond() > singular ? std::move(factor) : nullptr;
  } catch (const core::SolverError&) {
    return nullptr;
  }
}

/// Whether A x vanishes but for rounding for the x that inverse iteration finds: |A x| against |A| |x|. A slow
/// mode of a machine has a ratio of 1e-6 to 1e-11, a state that nothing holds about 1e-16.
template <class Solve>
bool is_singular(const Sparse& a, const Solve& solve) {
  constexpr double within_rounding = 1e-14;
  VectorXd x = random_vector(a.rows());
  for (int i = 0; i < 3; ++i) {
    x = solve(x);
    if (!x.allFinite()) return true;
    x.normalize();
  }
  return (a * x).norm() <= within_rounding * (a.cwiseAbs() * x.cwiseAbs()).norm();
}

class LuFactor final : public ShiftFactor {
public:
  explicit LuFactor(PencilLu::Factor factor) : factor_(std::move(factor)) {}
  MatrixXcd solve(const MatrixXcd& b, bool transposed) const override { return factor_.solve(b, transposed); }
  MatrixXd solve_real(const MatrixXd& b, bool transposed) const override { return factor_.solve(b, transposed); }

private:
  PencilLu::Factor factor_;
};

class CholeskyFactor final : public ShiftFactor {
public:
  explicit CholeskyFactor(SparseFactor factor) : factor_(std::move(factor)) {}
  MatrixXcd solve(const MatrixXcd& b, bool) const override {
    const MatrixXd real = factor_.solve(b.real()), imaginary = factor_.solve(b.imag());
    return real.cast<Complex>() + Complex(0, 1) * imaginary.cast<Complex>();
  }
  MatrixXd solve_real(const MatrixXd& b, bool) const override { return factor_.solve(b); }

private:
  SparseFactor factor_;
};

class SparseSystem final : public SystemSolver {
public:
  SparseSystem(const StateSpace& system, const std::string& place, const SolverOptions& options)
      : system_(system),
        options_(options),
        lu_(system.E, system.A) {
    e_factor_ = symmetric_e() ? definite_factor(system.E) : nullptr;
    if (!e_factor_) require_regular_e(place);
    Sparse dissipation = -0.5 * (system.A + Sparse(system.A.transpose()));
    dissipation.makeCompressed();
    if (e_factor_) dissipation_factor_ = definite_factor(dissipation);
    // A factor of a singular matrix exists too, by rounding.
    if (dissipation_factor_ &&
        is_singular(dissipation, [&](const VectorXd& x) -> VectorXd { return dissipation_factor_->solve(x); }))
      dissipation_factor_ = nullptr;
    definite_ = system.symmetric && e_factor_ && dissipation_factor_;
    if (definite_) {
      pattern_ = 1.0 * system.E - 1.0 * system.A;
      pattern_.makeCompressed();
      analysis_ = solver::analyse(pattern_);
    }
    if (!dissipation_factor_) look_for_unstable(place);
  }

  bool dense() const override { return false; }
  bool proved_stable() const override { return dissipation_factor_ != nullptr; }
  Band band() const override { return band_; }
  std::vector<double> peaks() const override { return {}; }

  TwoSided solve(Complex s, const MatrixXcd& r, const MatrixXcd& l) const override {
    const auto factor = factorise(s);
    return {factor->solve(r, false), factor->solve(l, true)};
  }

  MatrixXcd response(Complex s) const override {
    const auto factor = factorise(s);
    if (system_.outputs() < system_.inputs())
      return factor->solve(system_.C.transpose().cast<Complex>(), true).transpose() * system_.B;
    return system_.C * factor->solve(system_.B.cast<Complex>(), false);
  }

  GramianFactors gramians() const override {
    AdiOptions options;
    options.residual = options_.residual;
    AdiFactors adi = low_rank_gramians(
        system_, [this](Complex s) { return factorise(s); }, options);
    band_ = {adi.smallest_shift, adi.largest_shift};
    GramianFactors result;
    result.complete = false;
    result.steps = adi.steps;
    result.residual = adi.residual;
    result.unknown_sum = unknown_sum(adi);
    result.core = adi.observability.transpose() * (system_.E * adi.controllability);
    result.controllability = std::move(adi.controllability);
    result.observability = std::move(adi.observability);
    return result;
  }

  Modes dominant_modes(Index count) const override {
    const Index steps = 3 * count + 40;
    const auto at_rest = factorise(0.0);
    constexpr double accuracy = 1e-8;
    const VectorXd start = random_vector(system_.size());
    // A x = value E x: (0 E - A)^-1 E x = -x / value.
    const auto pairs = [&](bool transposed) {
      const Sparse& e = system_.E;
      return arnoldi(
          [&](const VectorXd& x) -> VectorXd {
            return at_rest->solve_real(transposed ? VectorXd(e.transpose() * x) : VectorXd(e * x), transposed);
          },
          start, steps, accuracy);
    };
    const ArnoldiPairs right = pairs(false), left = definite_ ? right : pairs(true);
    Modes found = matched(right, left);
    VectorXd dominance(found.values.size());
    for (Index k = 0; k < dominance.size(); ++k) {
      dominance(k) = (system_.C * found.right.col(k)).norm() * (found.left.col(k).transpose() * system_.B).norm() /
                     std::abs(found.values(k).real());
    }
    const std::vector<Index> chosen = by_dominance(found.values, dominance, count);
    return {found.values(chosen), found.right(Eigen::all, chosen), found.left(Eigen::all, chosen)};
  }

private:
  bool symmetric_e() const {
    if (system_.symmetric || system_.identity) return true;
    const Sparse difference = system_.E - Sparse(system_.E.transpose());
    return difference.norm() <= 1e-14 * system_.E.norm();
  }
  std::unique_ptr<ShiftFactor> factorise(Complex s) const {
    if (definite_ && s.imag() == 0.0 && s.real() >= 0.0) {
      Sparse matrix = s.real() * system_.E - 1.0 * system_.A;
      matrix.makeCompressed();
      return std::make_unique<CholeskyFactor>(SparseFactor(matrix, {}, analysis_));
    }
    return std::make_unique<LuFactor>(lu_.factorise(s));
  }

  void require_regular_e(const std::string& place) const {
    const Sparse nothing(system_.size(), system_.size());
    const double rcond = PencilLu(system_.E, nothing).factorise(1.0).rcond();
    if (!(rcond > singular)) refuse_singular(place, system_.E, rcond);
  }

  /// Ritz values near 0 and near places to the right of it, up and down the imaginary axis.
  void look_for_unstable(const std::string& place) const {
    const double size = scale();
    const auto rest = lu_.factorise(0.0);
    if (!(rest.rcond() > singular) ||
        is_singular(system_.A, [&](const VectorXd& x) -> VectorXd { return rest.solve(MatrixXd(x), false); }))
      refuse_unstable(place, 0.0, true);
    constexpr Index steps = 60;
    constexpr double accuracy = 1e-6;
    const double slowest =
        1.0 /
        std::abs(arnoldi([&](const VectorXd& x) -> VectorXd { return rest.solve(MatrixXd(system_.E * x), false); },
                         random_vector(system_.size()), steps, 1.0)
                     .values(0));
    for (const double shift : {0.0, slowest, std::sqrt(slowest * size), size}) {
      const auto factor = lu_.factorise(shift);
      const ArnoldiPairs pairs =
          arnoldi([&](const VectorXd& x) -> VectorXd { return factor.solve(MatrixXd(system_.E * x), false); },
                  random_vector(system_.size()), steps, accuracy);
      for (const Complex& value : pairs.values) {
        const Complex pole = shift - 1.0 / value;
        if (pole.real() >= 0.0) refuse_unstable(place, pole, false);
      }
    }
  }
  double scale() const {
    const double of_e = system_.E.norm(), of_a = system_.A.norm();
    return of_a / of_e;
  }

  /// Mirsky: singular values of Zc^T E Zb differ from all Hankel singular values by at most the sum of
  /// singular values of what the rests add to it. With x^T A x <= -decay x^T E x, the traces of the
  /// rests' Gramians are at most |W|^2 / (2 decay), in the norm of E^-1.
  std::optional<double> unknown_sum(const AdiFactors& adi) const {
    if (!dissipation_factor_) return std::nullopt;
    const ArnoldiPairs slow =
        arnoldi([&](const VectorXd& x) -> VectorXd { return dissipation_factor_->solve(MatrixXd(system_.E * x)); },
                random_vector(system_.size()), 60, 1.0);
    const double decay = 1.0 / std::abs(slow.values(0));
    const auto trace = [&](const MatrixXd& z) { return z.cwiseProduct(system_.E * z).sum(); };
    const auto rest = [&](const MatrixXd& w) { return w.cwiseProduct(e_factor_->solve(w)).sum() / (2.0 * decay); };
    const double p = trace(adi.controllability), q = trace(adi.observability);
    const double dp = rest(adi.controllability_rest), dq = rest(adi.observability_rest);
    return std::sqrt(p * dq) + std::sqrt(dp * q) + std::sqrt(dp * dq);
  }

  /// Right and left vectors of the same values.
  Modes matched(const ArnoldiPairs& right, const ArnoldiPairs& left) const {
    std::vector<std::pair<Index, Index>> pairs;
    std::vector<bool> used(left.values.size(), false);
    constexpr double same = 1e-6;
    for (Index i = 0; i < right.values.size(); ++i) {
      for (Index j = 0; j < left.values.size(); ++j) {
        if (used[j] || std::abs(right.values(i) - left.values(j)) > same * std::abs(right.values(i))) continue;
        used[j] = true;
        pairs.emplace_back(i, j);
        break;
      }
    }
    Modes modes{Eigen::VectorXcd(pairs.size()), MatrixXcd(system_.size(), pairs.size()),
                MatrixXcd(system_.size(), pairs.size())};
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto [i, j] = pairs[k];
      const Index to = k;
      modes.values(to) = -1.0 / right.values(i);
      modes.right.col(to) = right.vectors.col(i);
      const Complex overlap = left.vectors.col(j).transpose() * (system_.E * right.vectors.col(i));
      modes.left.col(to) = left.vectors.col(j) / overlap;
    }
    return modes;
  }

  const StateSpace& system_;
  SolverOptions options_;
  PencilLu lu_;
  std::unique_ptr<SparseFactor> e_factor_, dissipation_factor_;
  bool definite_ = false;
  Sparse pattern_;
  solver::SparseAnalysis analysis_;
  mutable Band band_;
};

}  // namespace

bool is_definite(const Sparse& matrix) { return definite_factor(matrix) != nullptr; }

std::unique_ptr<SystemSolver> make_sparse_solver(const StateSpace& system, const std::string& place,
                                                 const SolverOptions& options) {
  return std::make_unique<SparseSystem>(system, place, options);
}

}  // namespace thermotwin::reduction
