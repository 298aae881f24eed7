// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/multigrid.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "solver/linear/multigrid_levels.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Block = SideBySide;  // (unknowns x right-hand sides)
using RowOf = Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int columns_at_once = 8;
constexpr int spectrum_steps = 12;
constexpr double spectrum_top = 1.1, spectrum_bottom = 0.1;  // of the largest eigenvalue found

/// store(row, A x of that row) for all rows.
template <class Store>
void multiply(const Rows& a, const Block& x, const Store& store) {
  const int *outer = a.outerIndexPtr(), *inner = a.innerIndexPtr();
  const double *values = a.valuePtr(), *from = x.data();
  over_columns<columns_at_once>(x.cols(), [&](auto width, Index) {
    constexpr Index w = decltype(width)::value;
    over_rows(a.rows(), [&](Index first, Index last) {
      for (Index row = first; row < last; ++row) {
        double sum[columns_at_once] = {};
        for (int i = outer[row]; i < outer[row + 1]; ++i) {
          const double* at = from + inner[i] * w;
          for (int k = 0; k < w; ++k) sum[k] += values[i] * at[k];
        }
        store(row, static_cast<const double*>(sum));
      }
    });
  });
}

/// Largest eigenvalue of D^-1/2 A D^-1/2 by a few steps of Lanczos from a fixed start.
double largest_eigenvalue(const Rows& a, const VectorXd& inverse_diagonal) {
  const Index n = a.rows();
  const VectorXd root = inverse_diagonal.cwiseSqrt();
  VectorXd v(n), before = VectorXd::Zero(n), w(n);
  std::uint64_t random = 88172645463325252ULL;  // xorshift64
  for (double& value : v) {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    value = 0x1p-53 * (random >> 11) - 0.5;
  }
  v.normalize();
  const int steps = std::min<Index>(spectrum_steps, n);
  VectorXd diagonal(steps), off(std::max(0, steps - 1));
  Block scaled(n, 1);
  for (int i = 0; i < steps; ++i) {
    scaled = root.cwiseProduct(v);
    multiply(a, scaled, [&](Index row, const double* sum) { w[row] = root[row] * sum[0]; });
    if (i > 0) w -= off[i - 1] * before;
    diagonal[i] = v.dot(w);
    w -= diagonal[i] * v;
    const double norm = w.norm();
    if (i + 1 == steps || !(norm > 1e-12)) {
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
      eigen.computeFromTridiagonal(diagonal.head(i + 1), off.head(i), Eigen::EigenvaluesOnly);
      return eigen.eigenvalues().maxCoeff();
    }
    off[i] = norm;
    before = v;
    v = w / norm;
  }
  return 1.0;
}

struct Level {
  Rows matrix, prolongation, restriction;  // the last two to and from the next coarser level
  VectorXd inverse_diagonal;
  double top = 1.0;  // of the spectrum that is smoothed

  /// Chebyshev of degree 2 in D^-1 A: two corrections, the first from x as it is (or zero).
  void smooth(const Block& b, Block& x, bool from_zero, Block& direction) const {
    const double high = spectrum_top * top, low = spectrum_bottom * top;
    const double centre = 0.5 * (high + low), half = 0.5 * (high - low);
    const Index width = b.cols();
    direction.resize(b.rows(), width);
    const double first = 1.0 / centre;
    if (from_zero) {
      x.resize(b.rows(), width);
      over_rows(b.rows(), [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i) x.row(i) = direction.row(i) = first * inverse_diagonal[i] * b.row(i);
      });
    } else {
      multiply(matrix, x, [&](Index i, const double* sum) {
        const double scale = first * inverse_diagonal[i];
        for (Index k = 0; k < width; ++k) direction(i, k) = scale * (b(i, k) - sum[k]);
      });
      over_rows(b.rows(), [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i) x.row(i) += direction.row(i);
      });
    }
    // Second correction: rho1 = 1 / (2 sigma - rho0) with sigma = centre / half, rho0 = 1 / sigma.
    const double sigma = centre / half, rho = 1.0 / (2.0 * sigma - 1.0 / sigma);
    const double keep = rho / sigma, step = 2.0 * rho / half;
    multiply(matrix, x, [&](Index i, const double* sum) {
      const double scale = step * inverse_diagonal[i];
      for (Index k = 0; k < width; ++k) direction(i, k) = keep * direction(i, k) + scale * (b(i, k) - sum[k]);
    });
    over_rows(b.rows(), [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) x.row(i) += direction.row(i);
    });
  }
};

double bytes_of(const Rows& matrix) { return 12.0 * matrix.nonZeros() + 4.0 * matrix.rows(); }

}  // namespace

struct MultigridSolver::Impl {
  MultigridOptions options;
  std::vector<Level> levels;
  Eigen::LLT<Eigen::MatrixXd> coarsest;

  /// Working space of one block of right-hand sides, a set of vectors for each level.
  struct Space {
    struct OfLevel {
      Block b, x, direction;
    };
    std::vector<OfLevel> of;
  };

  void cycle(std::size_t l, Space& space) const {
    Space::OfLevel& here = space.of[l];
    if (l + 1 == levels.size()) {
      here.x = coarsest.solve(here.b);
      return;
    }
    const Level& level = levels[l];
    Space::OfLevel& below = space.of[l + 1];
    const Index width = here.b.cols();
    level.smooth(here.b, here.x, true, here.direction);
    multiply(level.matrix, here.x, [&](Index i, const double* sum) {
      for (Index k = 0; k < width; ++k) here.direction(i, k) = here.b(i, k) - sum[k];
    });
    below.b.resize(level.restriction.rows(), width);
    multiply(level.restriction, here.direction, [&](Index i, const double* sum) {
      for (Index k = 0; k < width; ++k) below.b(i, k) = sum[k];
    });
    cycle(l + 1, space);
    multiply(level.prolongation, below.x, [&](Index i, const double* sum) {
      for (Index k = 0; k < width; ++k) here.x(i, k) += sum[k];
    });
    level.smooth(here.b, here.x, false, here.direction);
  }

  /// Up to columns_at_once right-hand sides. @return iterations
  int solve_block(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> solution) const {
    const Index n = b.rows(), width = b.cols();
    Space space;
    space.of.resize(levels.size());
    Block x = Block::Zero(n, width), p = Block::Zero(n, width), ap(n, width);
    Block& r = space.of[0].b;
    const Block& z = space.of[0].x;
    r = b;
    const RowOf goal = (options.tolerance * options.tolerance) * dots(r, r).transpose();
    RowOf rho = RowOf::Zero(width), left = goal / (options.tolerance * options.tolerance);
    for (int i = 0; i <= options.max_iterations; ++i) {
      if (!(left > goal).any()) {
        solution = x;
        return i;
      }
      if (i == options.max_iterations || !left.allFinite()) break;
      cycle(0, space);
      const RowOf next = dots(r, z).transpose();
      // A column that is done, or was nothing from the start, stays as it is.
      const Eigen::Array<bool, 1, Eigen::Dynamic, Eigen::RowMajor> going = left > goal;
      const RowOf beta = (going && rho > 0.0).select(next / rho, 0.0);  // 0 in the first iteration
      over_rows(n, [&](Index first, Index last) {
        for (Index row = first; row < last; ++row) p.row(row).array() = z.row(row).array() + beta * p.row(row).array();
      });
      multiply(levels[0].matrix, p, [&](Index row, const double* sum) {
        for (Index k = 0; k < width; ++k) ap(row, k) = sum[k];
      });
      const RowOf curvature = dots(p, ap).transpose();
      const RowOf alpha = (going && curvature > 0.0).select(next / curvature, 0.0);
      over_rows(n, [&](Index first, Index last) {
        for (Index row = first; row < last; ++row) {
          x.row(row).array() += alpha * p.row(row).array();
          r.row(row).array() -= alpha * ap.row(row).array();
        }
      });
      rho = next;
      left = dots(r, r).transpose();
    }
    const double worst = std::sqrt((left / (goal / (options.tolerance * options.tolerance)).max(1e-300)).maxCoeff());
    throw core::SolverError(fmt::format(
        "multigrid: {} unknowns have a residual of {:.1e} after {} iterations, above the tolerance of {:.1e}. A body "
        "is not held, a part has no path to a given temperature, or elements are badly shaped",
        n, worst, options.max_iterations, options.tolerance));
  }
};

void MultigridOptions::validate() const {
  const std::string of = "multigrid options: ";
  core::require_within(of + "block", block, {1.0, 64.0});
  core::require_within(of + "tolerance", tolerance, {1e-16, 1.0});
  core::require_within(of + "max_iterations", max_iterations, {1.0, 1e9});
  if (!near_null.allFinite())
    throw core::InputError(of + "near_null", "an entry that is not a number", "finite values");
}

MultigridSolver::MultigridSolver(const Matrix& spd, const MultigridOptions& options) : impl_(std::make_unique<Impl>()) {
  Impl& impl = *impl_;
  options.validate();
  impl.options = options;
  std::vector<MultigridLevel> coarser = multigrid_levels(spd, options.block, options.near_null);
  impl.options.near_null.resize(0, 0);
  impl.levels.resize(coarser.size() + 1);
  // Symmetric: its columns are its rows.
  impl.levels[0].matrix = Eigen::Map<const Rows>(spd.rows(), spd.cols(), spd.nonZeros(), spd.outerIndexPtr(),
                                                 spd.innerIndexPtr(), spd.valuePtr());
  for (std::size_t l = 0; l < coarser.size(); ++l) {
    impl.levels[l].prolongation = std::move(coarser[l].prolongation);
    impl.levels[l].restriction = impl.levels[l].prolongation.transpose();
    impl.levels[l + 1].matrix = std::move(coarser[l].matrix);
  }
  for (Level& level : impl.levels) {
    const VectorXd diagonal = level.matrix.diagonal();
    const bool finest = &level == &impl.levels.front(), coarsest = &level == &impl.levels.back();
    if (finest && !(diagonal.minCoeff() > 0.0))
      throw core::SolverError(fmt::format("multigrid: the matrix of {} unknowns is not positive definite", spd.rows()));
    // An aggregate with fewer unknowns than modes leaves empty ones on the coarser level: never moved.
    const double empty = 1e-14 * diagonal.maxCoeff();
    level.inverse_diagonal = diagonal.unaryExpr([&](double value) { return value > empty ? 1.0 / value : 0.0; });
    if (!coarsest) level.top = largest_eigenvalue(level.matrix, level.inverse_diagonal);
  }
  Eigen::MatrixXd last(impl.levels.back().matrix);
  for (Index i = 0; i < last.rows(); ++i)
    if (impl.levels.back().inverse_diagonal[i] == 0.0) last(i, i) = 1.0;
  impl.coarsest.compute(last);
  if (impl.coarsest.info() != Eigen::Success) {
    throw core::SolverError(
        fmt::format("multigrid: the matrix of {} unknowns is not positive definite; a body is not held, or a part has "
                    "no path to a given temperature",
                    spd.rows()));
  }
}

MultigridSolver::~MultigridSolver() = default;
MultigridSolver::MultigridSolver(MultigridSolver&&) noexcept = default;
MultigridSolver& MultigridSolver::operator=(MultigridSolver&&) noexcept = default;

int MultigridSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_sides,
                           Eigen::Ref<Eigen::MatrixXd> solution) const {
  if (right_hand_sides.rows() != size()) {
    throw core::SolverError(
        fmt::format("multigrid: a right-hand side of {} rows for {} unknowns", right_hand_sides.rows(), size()));
  }
  const Index columns = right_hand_sides.cols(), blocks = (columns + columns_at_once - 1) / columns_at_once;
  std::vector<int> iterations(blocks, 0);
  core::parallel_for(0, blocks, [&](std::size_t i) {
    const Index first = columns * i / blocks, last = columns * (i + 1) / blocks;
    iterations[i] =
        impl_->solve_block(right_hand_sides.middleCols(first, last - first), solution.middleCols(first, last - first));
  });
  return iterations.empty() ? 0 : *std::max_element(iterations.begin(), iterations.end());
}

void MultigridSolver::precondition(const Eigen::Ref<const SideBySide>& right_hand_sides,
                                   Eigen::Ref<SideBySide> solution) const {
  const Index columns = right_hand_sides.cols(), blocks = (columns + columns_at_once - 1) / columns_at_once;
  core::parallel_for(0, blocks, [&](std::size_t i) {
    const Index first = columns * i / blocks, last = columns * (i + 1) / blocks;
    Impl::Space space;
    space.of.resize(impl_->levels.size());
    space.of[0].b = right_hand_sides.middleCols(first, last - first);
    impl_->cycle(0, space);
    solution.middleCols(first, last - first) = space.of[0].x;
  });
}

Index MultigridSolver::size() const { return impl_->levels.front().matrix.rows(); }
int MultigridSolver::levels() const { return std::ssize(impl_->levels); }

double MultigridSolver::memory_bytes() const {
  double bytes = 8.0 * (impl_->coarsest.matrixLLT().size());
  for (const Level& level : impl_->levels) {
    bytes += bytes_of(level.matrix) + bytes_of(level.prolongation) + bytes_of(level.restriction) +
             8.0 * level.inverse_diagonal.size();
  }
  return bytes;
}

}  // namespace thermotwin::solver
