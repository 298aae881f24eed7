// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/cholmod_factor.h"

#include <fmt/format.h>
#include <suitesparse/cholmod.h>

#include <algorithm>
#include <dlfcn.h>
#include <iterator>
#include <mutex>
#include <numeric>
#include <type_traits>

#include "core/error.h"
#include "solver/linear/blas.h"

namespace thermotwin::solver::cholmod {

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
  static constexpr auto rcond = cholmod_rcond;
  static constexpr auto free_factor = cholmod_free_factor;
  static constexpr auto copy_factor = cholmod_copy_factor;
  static constexpr auto change_factor = cholmod_change_factor;
};
struct Wide {
  using Index = SuiteSparse_long;
  static constexpr int itype = CHOLMOD_LONG;
  static constexpr auto start = cholmod_l_start;
  static constexpr auto finish = cholmod_l_finish;
  static constexpr auto analyze_p = cholmod_l_analyze_p;
  static constexpr auto factorize = cholmod_l_factorize;
  static constexpr auto rcond = cholmod_l_rcond;
  static constexpr auto free_factor = cholmod_l_free_factor;
  static constexpr auto copy_factor = cholmod_l_copy_factor;
  static constexpr auto change_factor = cholmod_l_change_factor;
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
    a.nrow = matrix.rows();
    a.ncol = matrix.cols();
    a.nzmax = matrix.nonZeros();
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

/// Pattern of the graph of nodes, lower triangle with diagonal.
SparseFactor::Matrix node_graph(const SparseFactor::Matrix& matrix, int block) {
  const int nodes = matrix.cols() / block;
  std::vector<int> outer{0}, inner, last(nodes, -1);
  for (int node = 0; node < nodes; ++node) {
    const auto first = std::ssize(inner);
    for (int k = 0; k < block; ++k) {
      for (SparseFactor::Matrix::InnerIterator it(matrix, node * block + k); it; ++it) {
        const int row = it.row() / block;
        if (row < node || last[row] == node) continue;
        last[row] = node;
        inner.push_back(row);
      }
    }
    std::sort(inner.begin() + first, inner.end());
    outer.push_back(inner.size());
  }
  const std::vector<double> ones(inner.size(), 1.0);
  return Eigen::Map<const SparseFactor::Matrix>(nodes, nodes, std::ssize(inner), outer.data(), inner.data(),
                                                ones.data());
}

double bytes_of(const cholmod_factor& f) {
  const double index = f.itype == CHOLMOD_LONG ? 8.0 : 4.0;
  // With the rows twice over for the sweeps.
  return f.is_super ? 8.0 * f.xsize + (index + 8.0) * f.ssize : (8.0 + index) * f.nzmax;
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

template <class Api>
class FactorOf final : public Factor {
public:
  FactorOf() = default;
  ~FactorOf() override { Api::free_factor(&factor_, &common_.data); }

  /// @return false where the indices overflow
  bool analyse(const SparseFactor::Matrix& spd, const std::vector<int>& order) {
    View<Api> view_of(spd);
    std::vector<typename Api::Index> permutation(order.begin(), order.end());
    factor_ = Api::analyze_p(&view_of.a, permutation.data(), nullptr, 0, &common_.data);
    if (!factor_ && common_.data.status == CHOLMOD_TOO_LARGE) return false;
    if (!factor_)
      throw SolverError(fmt::format("sparse factor: the analysis of {} unknowns failed (out of memory)", spd.cols()));
    flops = common_.data.fl;
    nonzeros = common_.data.lnz;
    return true;
  }
  /// Beside the factor: blocks of updates, the permuted matrix, maps.
  double work_bytes(const SparseFactor::Matrix& spd) const {
    const double index = sizeof(typename Api::Index);
    return 8.0 * factor_->maxcsize + (8.0 + index) * 0.5 * spd.nonZeros() + 6.0 * index * spd.cols();
  }

  void factorise(const SparseFactor::Matrix& spd, double many_core_flops) override {
    View<Api> view_of(spd);
    {
      keep_openmp_out();
      const BlasTurn turn(flops > many_core_flops);
      Api::factorize(&view_of.a, factor_, &common_.data);
    }
    if (common_.data.status == CHOLMOD_NOT_POSDEF) {
      throw SolverError(fmt::format(
          "sparse factor: the matrix of {} unknowns is not positive definite (at unknown {}); a body is not held, or a "
          "part has no path to a given temperature",
          spd.cols(),
          static_cast<typename Api::Index*>(factor_->Perm)[std::min<std::size_t>(factor_->minor, factor_->n - 1)]));
    }
    if (common_.data.status < 0) {
      throw SolverError(
          fmt::format("sparse factor: {} for {} unknowns and {:.3g} entries",
                      common_.data.status == CHOLMOD_OUT_OF_MEMORY ? "out of memory" : "the factorisation failed",
                      spd.cols(), nonzeros));
    }
    rcond = Api::rcond(factor_, &common_.data);
  }

  std::unique_ptr<Factor> copy() const override {
    auto other = std::make_unique<FactorOf>();
    other->factor_ = Api::copy_factor(factor_, &other->common_.data);
    if (!other->factor_)
      throw SolverError(fmt::format("sparse factor: out of memory for a copy of {:.3g} entries", nonzeros));
    other->rcond = rcond;
    other->flops = flops;
    other->nonzeros = nonzeros;
    return other;
  }
  bool wide() const override { return std::is_same_v<Api, Wide>; }
  double memory_bytes() const override { return bytes_of(*factor_); }
  const double* values() const override { return static_cast<const double*>(factor_->x); }
  void drop_values() override {
    if (!Api::change_factor(CHOLMOD_PATTERN, true, true, true, true, factor_, &common_.data))
      throw SolverError(fmt::format("sparse factor: the values of {:.3g} entries cannot be dropped", nonzeros));
  }
  SupernodalPattern pattern() const override { return pattern_of<typename Api::Index>(*factor_); }
  std::vector<int> permutation() const override {
    const auto* first = static_cast<const typename Api::Index*>(factor_->Perm);
    return {first, first + factor_->n};
  }

private:
  Common<Api> common_;
  cholmod_factor* factor_ = nullptr;
};

}  // namespace

std::vector<int> fill_reducing_order(const SparseFactor::Matrix& matrix, int block) {
  if (matrix.cols() % block != 0)
    throw SolverError(fmt::format("sparse factor: {} unknowns are no multiple of a block of {}", matrix.cols(), block));
  const SparseFactor::Matrix graph = block > 1 ? node_graph(matrix, block) : SparseFactor::Matrix();
  const SparseFactor::Matrix& ordered = block > 1 ? graph : matrix;
  const std::lock_guard lock(ordering_mutex());
  Common<Narrow> common;
  View<Narrow> view_of(ordered);
  std::vector<int> nodes(ordered.cols());
  constexpr Eigen::Index small = 300;
  bool done = false;
  if (ordered.cols() > small) done = cholmod_metis(&view_of.a, nullptr, 0, 1, nodes.data(), &common.data);
  if (!done) done = cholmod_amd(&view_of.a, nullptr, 0, nodes.data(), &common.data);
  if (!done) std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<int> order;
  order.reserve(nodes.size() * block);
  for (int node : nodes)
    for (int k = 0; k < block; ++k) order.push_back(node * block + k);
  return order;
}

std::unique_ptr<Factor> analysed(const SparseFactor::Matrix& spd, const std::vector<int>& order, bool wide,
                                 double* work) {
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

}  // namespace thermotwin::solver::cholmod
