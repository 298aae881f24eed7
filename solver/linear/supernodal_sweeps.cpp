// SPDX-License-Identifier: GPL-3.0-or-later

#ifdef __AVX__

#include "solver/linear/supernodal_sweeps.h"

#include <immintrin.h>
#endif

#include <algorithm>
#include <numeric>

#include "core/thread_pool.h"
#include "solver/linear/blas.h"
#include "solver/linear/side_by_side.h"

namespace thermotwin::solver {
namespace {

using Int = std::int64_t;

constexpr Int fewest_subtrees = 24;   // a subtree holds at most this share of the factor
constexpr Int rows_at_once = 128;     // of a block that stays in the nearest cache
constexpr Int split_above = 1 << 17;  // values of a supernode that several threads share

struct NoTurn {};

typedef float FourSingle __attribute__((vector_size(16), aligned(4), may_alias));
Four four(const double* from) { return *reinterpret_cast<const Four*>(from); }
Four four(const float* from) {
#ifdef __AVX__
  return _mm256_cvtps_pd(_mm_loadu_ps(from));  // what compilers make of the other line goes through memory
#else
  return __builtin_convertvector(*reinterpret_cast<const FourSingle*>(from), Four);
#endif
}

/// 4 N right-hand sides. Panels of columns are as wide as the registers hold their sums.
template <int N>
struct Wide {
  static constexpr Int width = 4 * N, most_width = width, panel = N == 3 ? 3 : 4;
  static constexpr Int columns_at_once = 16;
  using Turn = NoTurn;

  static Four* at(double* y, Int row) { return reinterpret_cast<Four*>(y + row * width); }
  static const Four* at(const double* y, Int row) { return reinterpret_cast<const Four*>(y + row * width); }

  template <int P, class Value>
  static void subtract_panel(const Value* l, Int stride, Int rows, const double* y, double* out) {
    Four from[P][N];
    for (int j = 0; j < P; ++j)
      for (int k = 0; k < N; ++k) from[j][k] = at(y, j)[k];
    for (Int i = 0; i < rows; ++i) {
      Four* to = at(out, i);
      Four sum[N];
      for (int k = 0; k < N; ++k) sum[k] = to[k];
      for (int j = 0; j < P; ++j)
        for (int k = 0; k < N; ++k) sum[k] -= double{l[j * stride + i]} * from[j][k];
      for (int k = 0; k < N; ++k) to[k] = sum[k];
    }
  }
  template <int P, class Value>
  static void subtract_transposed_panel(const Value* l, Int stride, Int rows, const double* x, double* out) {
    Four sum[P][N] = {};
    for (Int i = 0; i < rows; ++i) {
      const Four* from = at(x, i);
      for (int j = 0; j < P; ++j)
        for (int k = 0; k < N; ++k) sum[j][k] += double{l[j * stride + i]} * from[k];
    }
    for (int j = 0; j < P; ++j)
      for (int k = 0; k < N; ++k) at(out, j)[k] -= sum[j][k];
  }

  /// out (rows x width) -= L (rows x columns) y (columns x width)
  template <class Value>
  static void subtract(const Value* l, Int stride, Int rows, Int columns, const double* y, double* out) {
    Int j = 0;
    for (; j + panel <= columns; j += panel) subtract_panel<panel>(l + j * stride, stride, rows, y + j * width, out);
    for (; j + 2 <= columns; j += 2) subtract_panel<2>(l + j * stride, stride, rows, y + j * width, out);
    if (j < columns) subtract_panel<1>(l + j * stride, stride, rows, y + j * width, out);
  }
  /// out (columns x width) -= L^T x (rows x width)
  template <class Value>
  static void subtract_transposed(const Value* l, Int stride, Int rows, Int columns, const double* x, double* out) {
    Int j = 0;
    for (; j + panel <= columns; j += panel)
      subtract_transposed_panel<panel>(l + j * stride, stride, rows, x, out + j * width);
    for (; j + 2 <= columns; j += 2) subtract_transposed_panel<2>(l + j * stride, stride, rows, x, out + j * width);
    if (j < columns) subtract_transposed_panel<1>(l + j * stride, stride, rows, x, out + j * width);
  }
};

struct Single {
  static constexpr Int width = 1, most_width = 1, panel = 4;
  static constexpr Int columns_at_once = 16;
  using Turn = NoTurn;

  template <class Value>
  static void subtract(const Value* l, Int stride, Int rows, Int columns, const double* y, double* __restrict out) {
    Int j = 0;
    for (; j + 4 <= columns; j += 4) {
      const Value *l0 = l + j * stride, *l1 = l0 + stride, *l2 = l1 + stride, *l3 = l2 + stride;
      const double y0 = y[j], y1 = y[j + 1], y2 = y[j + 2], y3 = y[j + 3];
      for (Int i = 0; i < rows; ++i) out[i] -= l0[i] * y0 + l1[i] * y1 + l2[i] * y2 + l3[i] * y3;
    }
    for (; j < columns; ++j)
      for (Int i = 0; i < rows; ++i) out[i] -= l[j * stride + i] * y[j];
  }

  /// Sums of P columns at a time: as many are on their way at once.
  template <int P, class Value>
  static void subtract_dots(const Value* l, Int stride, Int rows, const double* x, double* out) {
    Four sum[P] = {};
    Int i = 0;
    for (; i + 4 <= rows; i += 4) {
      const Four at = four(x + i);
      for (int j = 0; j < P; ++j) sum[j] += four(l + j * stride + i) * at;
    }
    double rest[P] = {};
    for (; i < rows; ++i)
      for (int j = 0; j < P; ++j) rest[j] += l[j * stride + i] * x[i];
    for (int j = 0; j < P; ++j) out[j] -= (sum[j][0] + sum[j][1]) + (sum[j][2] + sum[j][3]) + rest[j];
  }
  template <class Value>
  static void subtract_transposed(const Value* l, Int stride, Int rows, Int columns, const double* x, double* out) {
    Int j = 0;
    for (; j + 4 <= columns; j += 4) subtract_dots<4>(l + j * stride, stride, rows, x, out + j);
    for (; j < columns; ++j) subtract_dots<1>(l + j * stride, stride, rows, x, out + j);
  }
};

/// Any number of right-hand sides, by the BLAS.
struct Many {
  static constexpr Int most_width = SupernodalSweeps::most_columns, columns_at_once = 64;
  using Turn = BlasTurn;
  Int width;

  void subtract(const double* l, Int stride, Int rows, Int columns, const double* y, double* out) const {
    blas_subtract(l, stride, rows, columns, y, out, width);
  }
  void subtract_transposed(const double* l, Int stride, Int rows, Int columns, const double* x, double* out) const {
    blas_subtract_transposed(l, stride, rows, columns, x, out, width);
  }
};

/// In place: L y for the lower triangle L, a panel of columns at a time.
template <class Kernel, class Value>
void solve_triangle(Kernel, const Value* l, Int stride, Int columns, double* y) {
  constexpr Int w = Kernel::width;
  for (Int first = 0; first < columns; first += Kernel::panel) {
    const Int last = std::min<Int>(columns, first + Kernel::panel);
    for (Int j = first; j < last; ++j) {
      const Value* column = l + j * stride;
      const double scale = 1.0 / column[j];
      for (Int k = 0; k < w; ++k) y[j * w + k] *= scale;
      for (Int i = j + 1; i < last; ++i)
        for (Int k = 0; k < w; ++k) y[i * w + k] -= column[i] * y[j * w + k];
    }
    Kernel::subtract(l + first * stride + last, stride, columns - last, last - first, y + first * w, y + last * w);
  }
}

template <class Kernel, class Value>
void solve_triangle_transposed(Kernel, const Value* l, Int stride, Int columns, double* y) {
  constexpr Int w = Kernel::width;
  for (Int first = (columns - 1) / Kernel::panel * Kernel::panel; first >= 0; first -= Kernel::panel) {
    const Int last = std::min<Int>(columns, first + Kernel::panel);
    Kernel::subtract_transposed(l + first * stride + last, stride, columns - last, last - first, y + last * w,
                                y + first * w);
    for (Int j = last - 1; j >= first; --j) {
      const Value* column = l + j * stride;
      for (Int i = j + 1; i < last; ++i)
        for (Int k = 0; k < w; ++k) y[j * w + k] -= column[i] * y[i * w + k];
      const double scale = 1.0 / column[j];
      for (Int k = 0; k < w; ++k) y[j * w + k] *= scale;
    }
  }
}

void solve_triangle(Many many, const double* l, Int stride, Int columns, double* y) {
  blas_solve_lower(l, stride, columns, y, many.width, false);
}

void solve_triangle_transposed(Many many, const double* l, Int stride, Int columns, double* y) {
  blas_solve_lower(l, stride, columns, y, many.width, true);
}

template <class Body>
void in_blocks(Int count, Int block, bool split, const Body& body) {
  if (!split) {
    for (Int first = 0; first < count; first += block) body(first, std::min(count, first + block));
    return;
  }
  core::parallel_for(0, (count + block - 1) / block, [&](std::size_t i) {
    const Int first = i * block;
    body(first, std::min(count, first + block));
  });
}

}  // namespace

SupernodalSweeps::SupernodalSweeps(SupernodalPattern pattern) : pattern_(std::move(pattern)) { plan(); }

void SupernodalSweeps::plan() {
  const SupernodalPattern& p = pattern_;
  const Int count = std::ssize(p.column) - 1;
  const auto at = [](Int i) { return static_cast<std::size_t>(i); };
  std::vector<Int> of_column(at(size()));
  for (Int s = 0; s < count; ++s)
    for (Int c = p.column[at(s)]; c < p.column[at(s + 1)]; ++c) of_column[at(c)] = s;
  const auto columns = [&](Int s) { return p.column[at(s + 1)] - p.column[at(s)]; };
  // Parent: where the first row below its own columns belongs to. A subtree is [first, s] if all in
  // between are its own.
  std::vector<Int> parent(at(count), count), first(at(count)), members(at(count), 1), weight(at(count));
  std::iota(first.begin(), first.end(), Int{0});
  for (Int s = 0; s < count; ++s) {
    weight[at(s)] += p.value_begin[at(s + 1)] - p.value_begin[at(s)];
    const Int below = p.row_begin[at(s)] + columns(s);
    if (below == p.row_begin[at(s + 1)]) continue;
    const Int up = of_column[at(p.row[at(below)])];
    parent[at(s)] = up;
    first[at(up)] = std::min(first[at(up)], first[at(s)]);
    members[at(up)] += members[at(s)];
    weight[at(up)] += weight[at(s)];
  }
  const Int limit = p.value_begin.back() / fewest_subtrees;
  target_ = p.row;
  work_rows_ = size();
  Int next = count - 1;
  for (Int s = count - 1; s >= 0; s = next) {
    const bool whole = s - first[at(s)] + 1 == members[at(s)];
    if (!whole || weight[at(s)] > limit) {
      top_.push_back(s);
      next = s - 1;
      continue;
    }
    // Its rows above are rows of its root: subtrees have places for these only.
    subtrees_.push_back({first[at(s)], s, work_rows_, s});
    const Int end = p.column[at(s + 1)];
    const int* outside = p.row.data() + p.row_begin[at(s)] + columns(s);
    const int* outside_end = p.row.data() + p.row_begin[at(s + 1)];
    for (Int i = p.row_begin[at(first[at(s)])]; i < p.row_begin[at(s + 1)]; ++i) {
      if (p.row[at(i)] >= end)
        target_[at(i)] = work_rows_ + (std::lower_bound(outside, outside_end, p.row[at(i)]) - outside);
    }
    work_rows_ += outside_end - outside;
    next = first[at(s)] - 1;
  }
  std::reverse(top_.begin(), top_.end());
  std::reverse(subtrees_.begin(), subtrees_.end());
}

template <class Kernel, class Value>
void SupernodalSweeps::forward(Kernel kernel, Int s, const Value* values, double* y, bool split) const {
  const Int w = kernel.width;
  const std::size_t at = s;
  const Int columns = pattern_.column[at + 1] - pattern_.column[at],
            stride = pattern_.row_begin[at + 1] - pattern_.row_begin[at];
  const Value* l = values + pattern_.value_begin[at];
  double* own = y + pattern_.column[at] * w;
  {
    [[maybe_unused]] const typename Kernel::Turn turn;
    solve_triangle(kernel, l, stride, columns, own);
  }
  const int* target = target_.data() + pattern_.row_begin[at] + columns;
  in_blocks(stride - columns, rows_at_once, split && stride * columns > split_above, [&](Int first, Int last) {
    [[maybe_unused]] const typename Kernel::Turn turn;
    alignas(32) double taken[rows_at_once * Kernel::most_width];
    std::fill_n(taken, (last - first) * w, 0.0);
    kernel.subtract(l + columns + first, stride, last - first, columns, own, taken);
    for (Int i = first; i < last; ++i) {
      double* to = y + target[i] * w;
      for (Int k = 0; k < w; ++k) to[k] += taken[(i - first) * w + k];
    }
  });
}

template <class Kernel, class Value>
void SupernodalSweeps::backward(Kernel kernel, Int s, const Value* values, double* y, bool split) const {
  const Int w = kernel.width;
  const std::size_t at = s;
  const Int columns = pattern_.column[at + 1] - pattern_.column[at],
            stride = pattern_.row_begin[at + 1] - pattern_.row_begin[at];
  const Value* l = values + pattern_.value_begin[at];
  double* own = y + pattern_.column[at] * w;
  const int* row = pattern_.row.data() + pattern_.row_begin[at] + columns;
  const bool shared = split && stride * columns > split_above;
  in_blocks(columns, shared ? Kernel::columns_at_once : columns, shared, [&](Int first, Int last) {
    [[maybe_unused]] const typename Kernel::Turn turn;
    alignas(32) double above[rows_at_once * Kernel::most_width];
    for (Int begin = 0; begin < stride - columns; begin += rows_at_once) {
      const Int end = std::min(stride - columns, begin + rows_at_once);
      for (Int i = begin; i < end; ++i)
        for (Int k = 0; k < w; ++k) above[(i - begin) * w + k] = y[row[i] * w + k];
      kernel.subtract_transposed(l + first * stride + columns + begin, stride, end - begin, last - first, above,
                                 own + first * w);
    }
  });
  [[maybe_unused]] const typename Kernel::Turn turn;
  solve_triangle_transposed(kernel, l, stride, columns, own);
}

template <class Kernel, class Value>
void SupernodalSweeps::run(Kernel kernel, const Value* values, double* y, bool backward_only) const {
  const Int w = kernel.width;
  if (!backward_only) {
    std::fill_n(y + size() * w, (work_rows_ - size()) * w, 0.0);
    core::parallel_for(0, subtrees_.size(), [&](std::size_t i) {
      for (Int s = subtrees_[i].first; s <= subtrees_[i].last; ++s) forward(kernel, s, values, y, false);
    });
    for (const Subtree& subtree : subtrees_) {
      const std::size_t root = subtree.root;
      const Int begin = pattern_.row_begin[root] + pattern_.column[root + 1] - pattern_.column[root];
      const double* from = y + subtree.extra_begin * w;
      for (Int i = begin; i < pattern_.row_begin[root + 1]; ++i, from += w) {
        double* to = y + pattern_.row[i] * w;
        for (Int k = 0; k < w; ++k) to[k] += from[k];
      }
    }
    for (const Int s : top_) forward(kernel, s, values, y, true);
  }
  for (auto s = top_.rbegin(); s != top_.rend(); ++s) backward(kernel, *s, values, y, true);
  core::parallel_for(0, subtrees_.size(), [&](std::size_t i) {
    for (Int s = subtrees_[i].last; s >= subtrees_[i].first; --s) backward(kernel, s, values, y, false);
  });
}

void SupernodalSweeps::solve(const double* values, double* y, int width, bool backward_only) const {
  if (width == 1) return run(Single{}, values, y, backward_only);
  if (width == 4) return run(Wide<1>{}, values, y, backward_only);
  if (width == 8) return run(Wide<2>{}, values, y, backward_only);
  if (width == 12) return run(Wide<3>{}, values, y, backward_only);
  run(Many{width}, values, y, backward_only);
}

void SupernodalSweeps::solve(const float* values, double* y, int width) const {
  if (width == 1) return run(Single{}, values, y, false);
  if (width == 4) return run(Wide<1>{}, values, y, false);
  if (width == 8) return run(Wide<2>{}, values, y, false);
  run(Wide<3>{}, values, y, false);
}

double SupernodalSweeps::memory_bytes() const {
  return 4.0 * (pattern_.row.size() + target_.size()) + 24.0 * pattern_.column.size();
}

}  // namespace thermotwin::solver
