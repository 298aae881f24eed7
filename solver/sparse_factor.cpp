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
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"

namespace thermotwin::solver {

using core::SolverError;

namespace {

/// CHOLMOD's settings and workspace; each call that may run beside others has its own.
struct Common {
  Common() {
    cholmod_start(&data);
    data.print = 0;
    data.supernodal = CHOLMOD_SUPERNODAL;
    data.final_ll = 1;
    data.nmethods = 1;
    data.method[0].ordering = CHOLMOD_GIVEN;
    data.postorder = 1;
    data.useGPU = 0;
  }
  ~Common() { cholmod_finish(&data); }
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

/// The matrix's own arrays as CHOLMOD sees them; the upper triangle is ignored.
cholmod_sparse view(const SparseFactor::Matrix& matrix) {
  cholmod_sparse a{};
  a.nrow = static_cast<std::size_t>(matrix.rows());
  a.ncol = static_cast<std::size_t>(matrix.cols());
  a.nzmax = static_cast<std::size_t>(matrix.nonZeros());
  a.p = const_cast<int*>(matrix.outerIndexPtr());
  a.i = const_cast<int*>(matrix.innerIndexPtr());
  a.x = const_cast<double*>(matrix.valuePtr());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

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
  Common common;
  cholmod_sparse a = view(ordered);
  std::vector<int> nodes(static_cast<std::size_t>(ordered.cols()));
  constexpr Eigen::Index small = 300;
  bool done = false;
  if (ordered.cols() > small) done = cholmod_metis(&a, nullptr, 0, 1, nodes.data(), &common.data);
  if (!done) done = cholmod_amd(&a, nullptr, 0, nodes.data(), &common.data);
  if (!done) std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<int> order;
  order.reserve(nodes.size() * static_cast<std::size_t>(block));
  for (int node : nodes)
    for (int k = 0; k < block; ++k) order.push_back(node * block + k);
  return order;
}

}  // namespace

struct SparseFactor::Impl {
  SparseFactorOptions options;
  Common common;
  cholmod_factor* factor = nullptr;
  Eigen::Index size = 0, nonzeros = 0;
  double flops = 0, factor_nonzeros = 0, rcond = 0;

  ~Impl() { cholmod_free_factor(&factor, &common.data); }

  void factorise(const Matrix& spd) {
    if (spd.rows() != size || spd.cols() != size || spd.nonZeros() != nonzeros || !spd.isCompressed())
      throw SolverError("sparse factor: the matrix has another pattern than the one analysed");
    cholmod_sparse a = view(spd);
    {
      keep_openmp_out();
      const BlasTurn turn(flops > options.many_core_flops);
      cholmod_factorize(&a, factor, &common.data);
    }
    if (common.data.status == CHOLMOD_NOT_POSDEF)
      throw SolverError(fmt::format(
          "sparse factor: the matrix of {} unknowns is not positive definite (at unknown {}); something is not held or "
          "has no path to a given temperature",
          size, static_cast<int*>(factor->Perm)[std::min<std::size_t>(factor->minor, factor->n - 1)]));
    if (common.data.status < 0)
      throw SolverError(fmt::format("sparse factor: {} for {} unknowns and {:.3g} entries",
                                    common.data.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory" : "the factorisation failed",
                                    size, factor_nonzeros));
    rcond = cholmod_rcond(factor, &common.data);
  }

  void solve_block(const double* b, Eigen::Index b_stride, double* x, Eigen::Index x_stride, Eigen::Index columns) const {
    Common own;
    cholmod_dense rhs = view(const_cast<double*>(b), size, columns, b_stride);
    cholmod_dense *solution = nullptr, *y = nullptr, *e = nullptr;
    bool ok = false;
    {
      const BlasTurn turn(false);
      ok = cholmod_solve2(CHOLMOD_A, factor, &rhs, nullptr, &solution, nullptr, &y, &e, &own.data);
    }
    if (ok)
      Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(x, size, columns, Eigen::OuterStride<>(x_stride)) =
          Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), size, columns);
    cholmod_free_dense(&solution, &own.data);
    cholmod_free_dense(&y, &own.data);
    cholmod_free_dense(&e, &own.data);
    if (!ok) throw SolverError(fmt::format("sparse factor: out of memory in a solve of {} x {}", size, columns));
  }
};

SparseFactor::SparseFactor(const Matrix& spd, const SparseFactorOptions& options) : impl_(std::make_unique<Impl>()) {
  Impl& impl = *impl_;
  impl.options = options;
  impl.size = spd.cols();
  impl.nonzeros = spd.nonZeros();
  std::vector<int> order = fill_reducing_order(spd, std::max(1, options.block));
  cholmod_sparse a = view(spd);
  impl.factor = cholmod_analyze_p(&a, order.data(), nullptr, 0, &impl.common.data);
  if (!impl.factor)
    throw SolverError(fmt::format("sparse factor: the analysis of {} unknowns failed (out of memory or too large)", impl.size));
  impl.flops = impl.common.data.fl;
  impl.factor_nonzeros = impl.common.data.lnz;
  impl.factorise(spd);
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
  copy->flops = impl_->flops;
  copy->factor_nonzeros = impl_->factor_nonzeros;
  copy->rcond = impl_->rcond;
  copy->factor = cholmod_copy_factor(impl_->factor, &copy->common.data);
  if (!copy->factor) throw SolverError(fmt::format("sparse factor: out of memory for a copy of {:.3g} entries", impl_->factor_nonzeros));
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
  const Eigen::Index width = std::max(1, impl_->options.columns_at_once);
  const Eigen::Index blocks = (columns + width - 1) / width;
  core::parallel_for(0, static_cast<std::size_t>(blocks), [&](std::size_t i) {
    const Eigen::Index first = columns * static_cast<Eigen::Index>(i) / blocks;
    const Eigen::Index last = columns * (static_cast<Eigen::Index>(i) + 1) / blocks;
    impl_->solve_block(right_hand_sides.col(first).data(), right_hand_sides.outerStride(), solution.col(first).data(),
                       solution.outerStride(), last - first);
  });
}

Eigen::Index SparseFactor::size() const { return impl_->size; }
double SparseFactor::memory_bytes() const {
  const cholmod_factor& f = *impl_->factor;
  return f.is_super ? 8.0 * static_cast<double>(f.xsize) + 4.0 * static_cast<double>(f.ssize)
                    : 12.0 * static_cast<double>(f.nzmax);
}
double SparseFactor::flops() const { return impl_->flops; }
double SparseFactor::nonzeros() const { return impl_->factor_nonzeros; }
double SparseFactor::rcond() const { return impl_->rcond; }

}  // namespace thermotwin::solver
