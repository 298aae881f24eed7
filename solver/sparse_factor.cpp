// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/sparse_factor.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <suitesparse/cholmod.h>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <shared_mutex>
#include <thread>
#include <type_traits>
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"
#include "solver/supernodal_sweeps.h"

namespace thermotwin::solver {

using core::SolverError;

namespace {

/// CHOLMOD has every function twice, with 32-bit and with 64-bit indices.
struct Narrow {
  using Index = int;
  static constexpr int itype = CHOLMOD_INT;
  static constexpr auto start = cholmod_start;
  static constexpr auto finish = cholmod_finish;
  static constexpr auto analyze_p = cholmod_analyze_p;
  static constexpr auto factorize = cholmod_factorize;
  static constexpr auto solve2 = cholmod_solve2;
  static constexpr auto rcond = cholmod_rcond;
  static constexpr auto free_factor = cholmod_free_factor;
  static constexpr auto copy_factor = cholmod_copy_factor;
  static constexpr auto free_dense = cholmod_free_dense;
};
struct Wide {
  using Index = SuiteSparse_long;
  static constexpr int itype = CHOLMOD_LONG;
  static constexpr auto start = cholmod_l_start;
  static constexpr auto finish = cholmod_l_finish;
  static constexpr auto analyze_p = cholmod_l_analyze_p;
  static constexpr auto factorize = cholmod_l_factorize;
  static constexpr auto solve2 = cholmod_l_solve2;
  static constexpr auto rcond = cholmod_l_rcond;
  static constexpr auto free_factor = cholmod_l_free_factor;
  static constexpr auto copy_factor = cholmod_l_copy_factor;
  static constexpr auto free_dense = cholmod_l_free_dense;
};

/// CHOLMOD's settings and workspace; each call that may run beside others has its own.
template <class Api>
struct Common {
  Common() {
    Api::start(&data);
    data.print = 0;
    data.supernodal = CHOLMOD_SUPERNODAL;
    data.final_ll = 1;
    data.nmethods = 1;
    data.method[0].ordering = CHOLMOD_GIVEN;
    data.postorder = 1;
    data.useGPU = 0;
  }
  ~Common() { Api::finish(&data); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common data;
};

/// Threads of the BLAS at hand. OpenBLAS is told through its own call where it is the BLAS in use;
/// the reference BLAS and ATLAS have one thread anyway. Who needs many cores has the BLAS alone.
class BlasTurn {
 public:
  explicit BlasTurn(bool many_cores) : many_cores_(many_cores) {
    if (many_cores) {
      mutex().lock();
      set(static_cast<int>(std::thread::hardware_concurrency()));
    } else {
      static std::once_flag once;
      std::call_once(once, [] { set(1); });
      mutex().lock_shared();
    }
  }
  ~BlasTurn() {
    if (many_cores_) {
      set(1);
      mutex().unlock();
    } else {
      mutex().unlock_shared();
    }
  }
  BlasTurn(const BlasTurn&) = delete;
  BlasTurn& operator=(const BlasTurn&) = delete;

 private:
  static std::shared_mutex& mutex() {
    static std::shared_mutex instance;
    return instance;
  }
  static void set(int threads) {
    using Setter = void (*)(int);
    static const auto setter = reinterpret_cast<Setter>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (setter) setter(std::max(1, threads));
  }
  bool many_cores_;
};

/// CHOLMOD copies blocks in OpenMP loops of four threads, whatever the pool does; this thread's
/// loops stay on it.
void keep_openmp_out() {
  using Setter = void (*)(int);
  static const auto setter = reinterpret_cast<Setter>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
  if (setter) setter(0);
}

/// METIS draws from rand(): two orderings at once would mix their random numbers.
std::mutex& ordering_mutex() {
  static std::mutex instance;
  return instance;
}

/// The matrix as CHOLMOD sees it, the upper triangle ignored: its own arrays, or wide copies of the indices.
template <class Api>
struct View {
  explicit View(const SparseFactor::Matrix& matrix) {
    a.nrow = static_cast<std::size_t>(matrix.rows());
    a.ncol = static_cast<std::size_t>(matrix.cols());
    a.nzmax = static_cast<std::size_t>(matrix.nonZeros());
    if constexpr (std::is_same_v<Api, Narrow>) {
      a.p = const_cast<int*>(matrix.outerIndexPtr());
      a.i = const_cast<int*>(matrix.innerIndexPtr());
    } else {
      outer.assign(matrix.outerIndexPtr(), matrix.outerIndexPtr() + matrix.cols() + 1);
      inner.assign(matrix.innerIndexPtr(), matrix.innerIndexPtr() + matrix.nonZeros());
      a.p = outer.data();
      a.i = inner.data();
    }
    a.x = const_cast<double*>(matrix.valuePtr());
    a.stype = -1;
    a.itype = Api::itype;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = 1;
    a.packed = 1;
  }
  cholmod_sparse a{};
  std::vector<SuiteSparse_long> outer, inner;
};

cholmod_dense view(double* values, Eigen::Index rows, Eigen::Index columns, Eigen::Index stride) {
  cholmod_dense b{};
  b.nrow = static_cast<std::size_t>(rows);
  b.ncol = static_cast<std::size_t>(columns);
  b.d = static_cast<std::size_t>(stride);
  b.nzmax = b.d * b.ncol;
  b.x = values;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  return b;
}

/// Pattern of the graph of nodes, lower triangle with diagonal.
SparseFactor::Matrix node_graph(const SparseFactor::Matrix& matrix, int block) {
  const int nodes = static_cast<int>(matrix.cols()) / block;
  std::vector<int> outer{0}, inner, last(static_cast<std::size_t>(nodes), -1);
  for (int node = 0; node < nodes; ++node) {
    const auto first = static_cast<std::ptrdiff_t>(inner.size());
    for (int k = 0; k < block; ++k)
      for (SparseFactor::Matrix::InnerIterator it(matrix, node * block + k); it; ++it) {
        const int row = static_cast<int>(it.row()) / block;
        if (row < node || last[static_cast<std::size_t>(row)] == node) continue;
        last[static_cast<std::size_t>(row)] = node;
        inner.push_back(row);
      }
    std::sort(inner.begin() + first, inner.end());
    outer.push_back(static_cast<int>(inner.size()));
  }
  const std::vector<double> ones(inner.size(), 1.0);
  return Eigen::Map<const SparseFactor::Matrix>(nodes, nodes, static_cast<Eigen::Index>(inner.size()), outer.data(),
                                                inner.data(), ones.data());
}

std::vector<int> fill_reducing_order(const SparseFactor::Matrix& matrix, int block) {
  if (matrix.cols() % block != 0)
    throw SolverError(fmt::format("sparse factor: {} unknowns are no multiple of a block of {}", matrix.cols(), block));
  const SparseFactor::Matrix graph = block > 1 ? node_graph(matrix, block) : SparseFactor::Matrix();
  const SparseFactor::Matrix& ordered = block > 1 ? graph : matrix;
  const std::lock_guard lock(ordering_mutex());
  Common<Narrow> common;
  View<Narrow> view_of(ordered);
  std::vector<int> nodes(static_cast<std::size_t>(ordered.cols()));
  constexpr Eigen::Index small = 300;
  bool done = false;
  if (ordered.cols() > small) done = cholmod_metis(&view_of.a, nullptr, 0, 1, nodes.data(), &common.data);
  if (!done) done = cholmod_amd(&view_of.a, nullptr, 0, nodes.data(), &common.data);
  if (!done) std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<int> order;
  order.reserve(nodes.size() * static_cast<std::size_t>(block));
  for (int node : nodes)
    for (int k = 0; k < block; ++k) order.push_back(node * block + k);
  return order;
}

double bytes_of(const cholmod_factor& f) {
  const double index = f.itype == CHOLMOD_LONG ? 8.0 : 4.0;
  // With the rows twice over for the sweeps.
  return f.is_super ? 8.0 * static_cast<double>(f.xsize) + (index + 8.0) * static_cast<double>(f.ssize)
                    : (8.0 + index) * static_cast<double>(f.nzmax);
}

template <class Index>
std::vector<std::int64_t> copied(const void* from, std::size_t count) {
  const auto* first = static_cast<const Index*>(from);
  return {first, first + count};
}

template <class Index>
SupernodalPattern pattern_of(const cholmod_factor& f) {
  SupernodalPattern pattern;
  pattern.column = copied<Index>(f.super, f.nsuper + 1);
  pattern.row_begin = copied<Index>(f.pi, f.nsuper + 1);
  pattern.value_begin = copied<Index>(f.px, f.nsuper + 1);
  const auto* row = static_cast<const Index*>(f.s);
  pattern.row.assign(row, row + pattern.row_begin.back());
  return pattern;
}

/// Working blocks of sweeps, kept for the next solve: fresh memory costs as much as the copies.
class SweepSpace {
 public:
  std::vector<double> take(std::size_t size) {
    std::vector<double> space;
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        space = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (space.size() < size) space = std::vector<double>(size);
    return space;
  }
  void give(std::vector<double> space) {
    const std::lock_guard lock(mutex_);
    if (free_.size() < 2) free_.push_back(std::move(space));
  }

 private:
  std::mutex mutex_;
  std::vector<std::vector<double>> free_;
};

/// A factor with the functions that go with its indices.
class AnyFactor {
 public:
  virtual ~AnyFactor() = default;
  virtual void factorise(const SparseFactor::Matrix& spd, double flops, double many_core_flops) = 0;
  virtual void solve(const double* b, Eigen::Index b_stride, double* x, Eigen::Index x_stride, Eigen::Index columns) const = 0;
  virtual std::unique_ptr<AnyFactor> copy() const = 0;
  virtual const cholmod_factor& data() const = 0;
  virtual SupernodalPattern pattern() const = 0;
  /// Place of each row of the factor in the matrix.
  virtual std::vector<int> permutation() const = 0;
  double rcond = 0, flops = 0, nonzeros = 0;
};

template <class Api>
class FactorOf final : public AnyFactor {
 public:
  FactorOf() = default;
  ~FactorOf() override { Api::free_factor(&factor_, &common_.data); }

  /// @return false where the indices overflow
  bool analyse(const SparseFactor::Matrix& spd, const std::vector<int>& order) {
    View<Api> view_of(spd);
    std::vector<typename Api::Index> permutation(order.begin(), order.end());
    factor_ = Api::analyze_p(&view_of.a, permutation.data(), nullptr, 0, &common_.data);
    if (!factor_ && common_.data.status == CHOLMOD_TOO_LARGE) return false;
    if (!factor_) throw SolverError(fmt::format("sparse factor: the analysis of {} unknowns failed (out of memory)", spd.cols()));
    flops = common_.data.fl;
    nonzeros = common_.data.lnz;
    return true;
  }
  /// Beside the factor: blocks of updates, the permuted matrix, maps.
  double work_bytes(const SparseFactor::Matrix& spd) const {
    const double index = sizeof(typename Api::Index);
    return 8.0 * static_cast<double>(factor_->maxcsize) + (8.0 + index) * 0.5 * static_cast<double>(spd.nonZeros()) +
           6.0 * index * static_cast<double>(spd.cols());
  }

  void factorise(const SparseFactor::Matrix& spd, double operations, double many_core_flops) override {
    View<Api> view_of(spd);
    {
      keep_openmp_out();
      const BlasTurn turn(operations > many_core_flops);
      Api::factorize(&view_of.a, factor_, &common_.data);
    }
    if (common_.data.status == CHOLMOD_NOT_POSDEF)
      throw SolverError(fmt::format(
          "sparse factor: the matrix of {} unknowns is not positive definite (at unknown {}); something is not held or "
          "has no path to a given temperature",
          spd.cols(), static_cast<typename Api::Index*>(factor_->Perm)[std::min<std::size_t>(factor_->minor, factor_->n - 1)]));
    if (common_.data.status < 0)
      throw SolverError(fmt::format("sparse factor: {} for {} unknowns and {:.3g} entries",
                                    common_.data.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory" : "the factorisation failed",
                                    spd.cols(), nonzeros));
    rcond = Api::rcond(factor_, &common_.data);
  }

  void solve(const double* b, Eigen::Index b_stride, double* x, Eigen::Index x_stride, Eigen::Index columns) const override {
    Common<Api> own;
    const auto size = static_cast<Eigen::Index>(factor_->n);
    cholmod_dense rhs = view(const_cast<double*>(b), size, columns, b_stride);
    cholmod_dense *solution = nullptr, *y = nullptr, *e = nullptr;
    bool ok = false;
    {
      const BlasTurn turn(false);
      ok = Api::solve2(CHOLMOD_A, factor_, &rhs, nullptr, &solution, nullptr, &y, &e, &own.data);
    }
    if (ok)
      Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(x, size, columns, Eigen::OuterStride<>(x_stride)) =
          Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), size, columns);
    Api::free_dense(&solution, &own.data);
    Api::free_dense(&y, &own.data);
    Api::free_dense(&e, &own.data);
    if (!ok) throw SolverError(fmt::format("sparse factor: out of memory in a solve of {} x {}", size, columns));
  }

  std::unique_ptr<AnyFactor> copy() const override {
    auto other = std::make_unique<FactorOf>();
    other->factor_ = Api::copy_factor(factor_, &other->common_.data);
    if (!other->factor_) throw SolverError(fmt::format("sparse factor: out of memory for a copy of {:.3g} entries", nonzeros));
    other->rcond = rcond;
    other->flops = flops;
    other->nonzeros = nonzeros;
    return other;
  }
  const cholmod_factor& data() const override { return *factor_; }
  SupernodalPattern pattern() const override { return pattern_of<typename Api::Index>(*factor_); }
  std::vector<int> permutation() const override {
    const auto* first = static_cast<const typename Api::Index*>(factor_->Perm);
    return {first, first + factor_->n};
  }

 private:
  Common<Api> common_;
  cholmod_factor* factor_ = nullptr;
};

/// @param count  receives the working memory, if given
std::unique_ptr<AnyFactor> analysed(const SparseFactor::Matrix& spd, const std::vector<int>& order, bool wide, double* work = nullptr) {
  if (!wide) {
    auto factor = std::make_unique<FactorOf<Narrow>>();
    if (factor->analyse(spd, order)) {
      if (work) *work = factor->work_bytes(spd);
      return factor;
    }
  }
  auto factor = std::make_unique<FactorOf<Wide>>();
  if (!factor->analyse(spd, order))
    throw SolverError(fmt::format("sparse factor: {} unknowns are too many even for 64-bit indices", spd.cols()));
  if (work) *work = factor->work_bytes(spd);
  return factor;
}

}  // namespace

struct SparseFactor::Impl {
  SparseFactorOptions options;
  std::unique_ptr<AnyFactor> factor;
  Eigen::Index size = 0, nonzeros = 0;
  std::shared_ptr<const SupernodalSweeps> sweeps;       // shared by clones, as their permutation
  std::shared_ptr<const std::vector<int>> permutation;
  mutable SweepSpace space;

  void factorise(const Matrix& spd) {
    if (spd.rows() != size || spd.cols() != size || spd.nonZeros() != nonzeros || !spd.isCompressed())
      throw SolverError("sparse factor: the matrix has another pattern than the one analysed");
    factor->factorise(spd, factor->flops, options.many_core_flops);
    if (!sweeps) {
      sweeps = std::make_shared<const SupernodalSweeps>(factor->pattern());
      permutation = std::make_shared<const std::vector<int>>(factor->permutation());
    }
  }

  /// Up to SupernodalSweeps::most_columns right-hand sides; entry (i, k) of b and x at i * row + k * column.
  struct Strides { Eigen::Index row, column; };
  void sweep(const double* b, Strides of_b, double* x, Strides of_x, Eigen::Index columns) const {
    const int width = SupernodalSweeps::width_for(columns);
    std::vector<double> work = space.take(static_cast<std::size_t>(sweeps->work_rows() * width));
    double* y = work.data();
    const int* place = permutation->data();
    constexpr Eigen::Index rows_at_once = 4096;
    const auto over_rows = [&](const auto& body) {
      core::parallel_for(0, static_cast<std::size_t>((size + rows_at_once - 1) / rows_at_once), [&](std::size_t part) {
        const Eigen::Index first = static_cast<Eigen::Index>(part) * rows_at_once, last = std::min(size, first + rows_at_once);
        for (Eigen::Index i = first; i < last; ++i) body(y + i * width, place[i]);
      });
    };
    over_rows([&](double* to, Eigen::Index i) {
      for (Eigen::Index k = 0; k < columns; ++k) to[k] = b[i * of_b.row + k * of_b.column];
      for (Eigen::Index k = columns; k < width; ++k) to[k] = 0.0;
    });
    sweeps->solve(static_cast<const double*>(factor->data().x), y, width);
    over_rows([&](const double* from, Eigen::Index i) {
      for (Eigen::Index k = 0; k < columns; ++k) x[i * of_x.row + k * of_x.column] = from[k];
    });
    space.give(std::move(work));
  }
};

SparseAnalysis analyse(const SparseFactor::Matrix& spd, const SparseFactorOptions& options) {
  SparseAnalysis analysis;
  analysis.order = fill_reducing_order(spd, std::max(1, options.block));
  const std::unique_ptr<AnyFactor> factor = analysed(spd, analysis.order, options.force_wide, &analysis.work_bytes);
  analysis.factor_bytes = bytes_of(factor->data());
  analysis.nonzeros = factor->nonzeros;
  analysis.flops = factor->flops;
  analysis.wide = factor->data().itype == CHOLMOD_LONG;
  return analysis;
}

SparseFactor::SparseFactor(const Matrix& spd, const SparseFactorOptions& options)
    : SparseFactor(spd, options, {fill_reducing_order(spd, std::max(1, options.block)), 0, 0, 0, 0, options.force_wide}) {}

SparseFactor::SparseFactor(const Matrix& spd, const SparseFactorOptions& options, const SparseAnalysis& analysis)
    : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
  impl_->size = spd.cols();
  impl_->nonzeros = spd.nonZeros();
  impl_->factor = analysed(spd, analysis.order, analysis.wide || options.force_wide);
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
  if (right_hand_sides.rows() != impl_->size)
    throw SolverError(fmt::format("sparse factor: a right-hand side of {} rows for {} unknowns", right_hand_sides.rows(), impl_->size));
  if (columns <= SupernodalSweeps::most_columns)
    return impl_->sweep(right_hand_sides.data(), {1, right_hand_sides.outerStride()}, solution.data(), {1, solution.outerStride()}, columns);
  const Eigen::Index width = std::max(1, impl_->options.columns_at_once);
  const Eigen::Index blocks = (columns + width - 1) / width;
  core::parallel_for(0, static_cast<std::size_t>(blocks), [&](std::size_t i) {
    const Eigen::Index first = columns * static_cast<Eigen::Index>(i) / blocks;
    const Eigen::Index last = columns * (static_cast<Eigen::Index>(i) + 1) / blocks;
    impl_->factor->solve(right_hand_sides.col(first).data(), right_hand_sides.outerStride(), solution.col(first).data(),
                       solution.outerStride(), last - first);
  });
}

void SparseFactor::solve_side_by_side(const Eigen::Ref<const SideBySide>& right_hand_sides, Eigen::Ref<SideBySide> solution) const {
  if (right_hand_sides.rows() != impl_->size)
    throw SolverError(fmt::format("sparse factor: a right-hand side of {} rows for {} unknowns", right_hand_sides.rows(), impl_->size));
  constexpr Eigen::Index width = SupernodalSweeps::most_columns;
  const Eigen::Index columns = right_hand_sides.cols(), blocks = (columns + width - 1) / width;
  core::parallel_for(0, static_cast<std::size_t>(blocks), [&](std::size_t i) {
    const Eigen::Index first = columns * static_cast<Eigen::Index>(i) / blocks, last = columns * (static_cast<Eigen::Index>(i) + 1) / blocks;
    impl_->sweep(right_hand_sides.data() + first, {right_hand_sides.outerStride(), 1}, solution.data() + first, {solution.outerStride(), 1},
                 last - first);
  });
}

Eigen::Index SparseFactor::size() const { return impl_->size; }
double SparseFactor::memory_bytes() const { return bytes_of(impl_->factor->data()); }
bool SparseFactor::wide() const { return impl_->factor->data().itype == CHOLMOD_LONG; }
double SparseFactor::flops() const { return impl_->factor->flops; }
double SparseFactor::nonzeros() const { return impl_->factor->nonzeros; }
double SparseFactor::rcond() const { return impl_->factor->rcond; }

}  // namespace thermotwin::solver
