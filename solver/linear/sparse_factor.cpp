// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/sparse_factor.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>

#include "core/error.h"
#include "core/range.h"
#include "core/thread_pool.h"
#include "solver/linear/cholmod_factor.h"

namespace thermotwin::solver {

using core::SolverError;

namespace {

/// A working block of a sweep. Values are not set.
struct Space {
  std::size_t size = 0;
  std::unique_ptr<double[]> values;
};

/// Small ones are kept for the next solve: fresh memory costs as much as the copies.
class SpaceStore {
public:
  Space take(std::size_t size) {
    Space space;
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        space = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (space.size < size) space = {size, std::make_unique_for_overwrite<double[]>(size)};
    return space;
  }
  void give(Space space) {
    const std::lock_guard lock(mutex_);
    if (free_.size() < 2) free_.push_back(std::move(space));
  }

private:
  std::mutex mutex_;
  std::vector<Space> free_;
};

}  // namespace

struct SparseFactor::Impl {
  SparseFactorOptions options;
  std::unique_ptr<cholmod::Factor> factor;
  Eigen::Index size = 0, nonzeros = 0;
  std::shared_ptr<const SupernodalSweeps> sweeps;  // shared by clones, as their permutation
  std::shared_ptr<const std::vector<int>> permutation;
  std::vector<float> single_values;  ///< instead of the factor's own
  mutable SpaceStore spaces;

  void factorise(const Matrix& spd) {
    if (spd.rows() != size || spd.cols() != size || spd.nonZeros() != nonzeros || !spd.isCompressed())
      throw SolverError("sparse factor: the matrix has another pattern than the one analysed");
    factor->factorise(spd, options.many_core_flops);
    if (!sweeps) {
      sweeps = std::make_shared<const SupernodalSweeps>(factor->pattern());
      permutation = std::make_shared<const std::vector<int>>(factor->permutation());
    }
    if (options.single_precision) {
      const double* values = factor->values();
      single_values.assign(values, values + sweeps->values());
      factor->drop_values();
    }
  }

  Eigen::Index most_columns() const {
    return std::clamp(options.columns_at_once, 1,
                      options.single_precision ? SupernodalSweeps::few_columns : SupernodalSweeps::most_columns);
  }

  /// Right-hand sides in one pass through the factor; entry (i, k) of b and x at i * row + k * column.
  struct Strides {
    Eigen::Index row, column;
  };
  void sweep(const double* b, Strides of_b, double* x, Strides of_x, Eigen::Index columns,
             bool backward_only = false) const {
    const int width = SupernodalSweeps::width_for(columns);
    const std::size_t needed = sweeps->work_rows() * width;
    const bool few = width <= SupernodalSweeps::few_columns;
    Space space = few ? spaces.take(needed) : Space{needed, std::make_unique_for_overwrite<double[]>(needed)};
    double* y = space.values.get();
    const int* place = permutation->data();
    // Eight columns at a time: as many rows of them stay in the cache as are near each other.
    constexpr Eigen::Index rows_at_once = 4096, columns_at_once = 8;
    const auto over_parts = [&](Eigen::Index all_columns, const auto& body) {
      core::parallel_for(0, (size + rows_at_once - 1) / rows_at_once, [&](std::size_t part) {
        const Eigen::Index first = part * rows_at_once, last = std::min(size, first + rows_at_once);
        for (Eigen::Index k = 0; k < all_columns; k += columns_at_once) {
          const Eigen::Index end = std::min(all_columns, k + columns_at_once);
          for (Eigen::Index i = first; i < last; ++i) body(y + i * width, place[i], k, end);
        }
      });
    };
    over_parts(width, [&](double* to, Eigen::Index i, Eigen::Index k, Eigen::Index end) {
      for (; k < std::min(end, columns); ++k) to[k] = b[i * of_b.row + k * of_b.column];
      for (; k < end; ++k) to[k] = 0.0;
    });
    if (options.single_precision)
      sweeps->solve(single_values.data(), y, width);
    else
      sweeps->solve(factor->values(), y, width, backward_only);
    over_parts(columns, [&](const double* from, Eigen::Index i, Eigen::Index k, Eigen::Index end) {
      for (; k < end; ++k) x[i * of_x.row + k * of_x.column] = from[k];
    });
    if (few) spaces.give(std::move(space));
  }
};

void SparseFactorOptions::validate() const {
  const std::string of = "sparse factor options: ";
  core::require_within(of + "block", block, {1.0, 64.0});
  core::require_within(of + "columns_at_once", columns_at_once, {1.0, 64.0});
  core::require_within(of + "many_core_flops", many_core_flops, core::non_negative);
}

SparseAnalysis analyse(const SparseFactor::Matrix& spd, const SparseFactorOptions& options) {
  options.validate();
  SparseAnalysis analysis;
  analysis.order = cholmod::fill_reducing_order(spd, options.block);
  const std::unique_ptr<cholmod::Factor> factor =
      cholmod::analysed(spd, analysis.order, options.force_wide, &analysis.work_bytes);
  analysis.factor_bytes = factor->memory_bytes();
  analysis.nonzeros = factor->nonzeros;
  analysis.flops = factor->flops;
  analysis.wide = factor->wide();
  return analysis;
}

namespace {

SparseAnalysis order_only(const SparseFactor::Matrix& spd, const SparseFactorOptions& options) {
  options.validate();
  return {cholmod::fill_reducing_order(spd, options.block), 0, 0, 0, 0, options.force_wide};
}

}  // namespace

SparseFactor::SparseFactor(const Matrix& spd, const SparseFactorOptions& options)
    : SparseFactor(spd, options, order_only(spd, options)) {}

SparseFactor::SparseFactor(const Matrix& spd, const SparseFactorOptions& options, const SparseAnalysis& analysis)
    : impl_(std::make_unique<Impl>()) {
  options.validate();
  impl_->options = options;
  impl_->size = spd.cols();
  impl_->nonzeros = spd.nonZeros();
  impl_->factor = cholmod::analysed(spd, analysis.order, analysis.wide || options.force_wide);
  impl_->factorise(spd);
}

SparseFactor::SparseFactor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SparseFactor::~SparseFactor() = default;
SparseFactor::SparseFactor(SparseFactor&&) noexcept = default;
SparseFactor& SparseFactor::operator=(SparseFactor&&) noexcept = default;

SparseFactor SparseFactor::clone() const {
  auto copy = std::make_unique<Impl>();
  copy->options = impl_->options;
  copy->size = impl_->size;
  copy->nonzeros = impl_->nonzeros;
  copy->factor = impl_->factor->copy();
  copy->sweeps = impl_->sweeps;
  copy->permutation = impl_->permutation;
  copy->single_values = impl_->single_values;
  return SparseFactor(std::move(copy));
}

void SparseFactor::factorise(const Matrix& spd) { impl_->factorise(spd); }

Eigen::MatrixXd SparseFactor::solve(const Eigen::MatrixXd& right_hand_sides) const {
  Eigen::MatrixXd solution(right_hand_sides.rows(), right_hand_sides.cols());
  solve(right_hand_sides, solution);
  return solution;
}

void SparseFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_sides,
                         Eigen::Ref<Eigen::MatrixXd> solution) const {
  const Eigen::Index columns = right_hand_sides.cols();
  if (columns == 0) return;
  if (right_hand_sides.rows() != impl_->size) {
    throw SolverError(fmt::format("sparse factor: a right-hand side of {} rows for {} unknowns",
                                  right_hand_sides.rows(), impl_->size));
  }
  const Eigen::Index most = impl_->most_columns(), blocks = (columns + most - 1) / most;
  core::parallel_for(0, blocks, [&](std::size_t i) {
    const Eigen::Index first = columns * i / blocks, last = columns * (i + 1) / blocks;
    impl_->sweep(right_hand_sides.col(first).data(), {1, right_hand_sides.outerStride()}, solution.col(first).data(),
                 {1, solution.outerStride()}, last - first);
  });
}

Eigen::MatrixXd SparseFactor::half_solve(const Eigen::MatrixXd& b) const {
  if (b.rows() != impl_->size)
    throw SolverError(fmt::format("sparse factor: a block of {} rows for {} unknowns", b.rows(), impl_->size));
  if (impl_->options.single_precision)
    throw SolverError("sparse factor: half a solve needs values in double precision");
  Eigen::MatrixXd result(b.rows(), b.cols());
  const Eigen::Index most = impl_->most_columns(), blocks = (b.cols() + most - 1) / most;
  core::parallel_for(0, blocks, [&](std::size_t i) {
    const Eigen::Index first = i * most, count = std::min(most, b.cols() - first);
    impl_->sweep(b.col(first).data(), {1, b.outerStride()}, result.col(first).data(), {1, result.outerStride()}, count,
                 true);
  });
  return result;
}

void SparseFactor::solve_side_by_side(const Eigen::Ref<const SideBySide>& right_hand_sides,
                                      Eigen::Ref<SideBySide> solution) const {
  if (right_hand_sides.rows() != impl_->size) {
    throw SolverError(fmt::format("sparse factor: a right-hand side of {} rows for {} unknowns",
                                  right_hand_sides.rows(), impl_->size));
  }
  constexpr Eigen::Index width = SupernodalSweeps::few_columns;
  const Eigen::Index columns = right_hand_sides.cols(), blocks = (columns + width - 1) / width;
  core::parallel_for(0, blocks, [&](std::size_t i) {
    const Eigen::Index first = columns * i / blocks, last = columns * (i + 1) / blocks;
    impl_->sweep(right_hand_sides.data() + first, {right_hand_sides.outerStride(), 1}, solution.data() + first,
                 {solution.outerStride(), 1}, last - first);
  });
}

Eigen::Index SparseFactor::size() const { return impl_->size; }
double SparseFactor::memory_bytes() const { return impl_->factor->memory_bytes() - 4.0 * impl_->single_values.size(); }
bool SparseFactor::wide() const { return impl_->factor->wide(); }
double SparseFactor::flops() const { return impl_->factor->flops; }
double SparseFactor::nonzeros() const { return impl_->factor->nonzeros; }
double SparseFactor::rcond() const { return impl_->factor->rcond; }

}  // namespace thermotwin::solver
