// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Vectors of several load cases side by side, (unknowns x load cases) by rows: one pass over a matrix serves them all.
// Loops over rows run on the thread pool in fixed parts. Inner loops over load cases have a width that the compiler
// knows.

#include <Eigen/Core>

#include <algorithm>
#include <type_traits>

#include "core/thread_pool.h"

namespace thermotwin::solver {

using SideBySide = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Four numbers; the same on processors without registers of that width, only slower. A typedef, since clang drops the
/// alignment that an alias states.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

/// Sums of W load cases, in registers.
template <int W>
struct RowSum {
  static constexpr int fours = W / 4, rest = W % 4;
  Four four[fours > 0 ? fours : 1] = {};
  double one[rest > 0 ? rest : 1] = {};

  void add(double factor, const double* x) {
    for (int k = 0; k < fours; ++k) four[k] += factor * reinterpret_cast<const Four*>(x)[k];
    for (int k = 0; k < rest; ++k) one[k] += factor * x[4 * fours + k];
  }
  /// A factor for each load case.
  void add(const double* factor, const RowSum& x) {
    for (int k = 0; k < fours; ++k) four[k] += reinterpret_cast<const Four*>(factor)[k] * x.four[k];
    for (int k = 0; k < rest; ++k) one[k] += factor[4 * fours + k] * x.one[k];
  }
  void add(double factor, const RowSum& x) {
    for (int k = 0; k < fours; ++k) four[k] += factor * x.four[k];
    for (int k = 0; k < rest; ++k) one[k] += factor * x.one[k];
  }
  void put(double* to) const {
    for (int k = 0; k < fours; ++k) reinterpret_cast<Four*>(to)[k] = four[k];
    for (int k = 0; k < rest; ++k) to[4 * fours + k] = one[k];
  }
};

/// Calls body(first, last) in parallel for parts of at most at_once rows.
template <class Body>
void over_rows(Eigen::Index rows, const Body& body, Eigen::Index at_once = 2048) {
  core::parallel_for(0, (rows + at_once - 1) / at_once, [&](std::size_t part) {
    const Eigen::Index first = part * at_once;
    body(first, std::min(rows, first + at_once));
  });
}

/// Calls body(width, first column) one after another for blocks of at most `most` columns. The width is an
/// integral_constant, so that the body's loop over it is unrolled.
template <int most = 12, class Body>
void over_columns(Eigen::Index columns, const Body& body) {
  const auto constant = [&]<int... W>(std::integer_sequence<int, W...>, int width, Eigen::Index first) {
    ((width == W + 1 ? body(std::integral_constant<int, W + 1>(), first) : void()), ...);
  };
  const Eigen::Index turns = (columns + most - 1) / most;
  for (Eigen::Index t = 0; t < turns; ++t) {
    const Eigen::Index first = columns * t / turns, last = columns * (t + 1) / turns;
    constant(std::make_integer_sequence<int, most>(), last - first, first);
  }
}

/// Sums over all rows: body(row, sum, width, first column) adds its row to sum[width]. The order of summation does not
/// depend on the threads. @return (columns)
template <class Body>
Eigen::ArrayXd sum_rows(Eigen::Index rows, Eigen::Index columns, const Body& body) {
  constexpr std::size_t at_once = 4096;
  Eigen::ArrayXd total(columns);
  over_columns(columns, [&](auto width, Eigen::Index begin) {
    using Sum = Eigen::Array<double, decltype(width)::value, 1>;
    total.segment<decltype(width)::value>(begin) = core::parallel_reduce<Sum>(
        0, rows, at_once, Sum::Zero(),
        [&](std::size_t first, std::size_t last) -> Sum {
          double sum[decltype(width)::value] = {};
          for (std::size_t i = first; i < last; ++i) body(i, sum, width, begin);
          return Eigen::Map<const Sum>(sum);
        },
        [](Sum left, const Sum& right) -> Sum { return left + right; });
  });
  return total;
}

/// @return the inner product of each column of a with that of b, (columns)
inline Eigen::ArrayXd dots(const SideBySide& a, const SideBySide& b) {
  const double *x = a.data(), *y = b.data();
  const Eigen::Index stride = a.cols();
  return sum_rows(a.rows(), stride, [=](Eigen::Index i, double* sum, auto width, Eigen::Index begin) {
    for (int k = 0; k < width; ++k) sum[k] += x[i * stride + begin + k] * y[i * stride + begin + k];
  });
}

inline Eigen::VectorXd norms(const SideBySide& a) { return dots(a, a).sqrt(); }

/// Calls body(first, last) in parallel for parts of the entries of a block, numbered as in memory.
template <class Body>
void over_entries(const SideBySide& shape, const Body& body) {
  over_rows(shape.size(), body, 16384);
}

/// Copies columns (n x loads, by columns) to rows (n x loads, by rows).
inline void put_side_by_side(const Eigen::MatrixXd& columns, SideBySide& rows) {
  rows.resize(columns.rows(), columns.cols());
  over_rows(
      columns.rows(),
      [&](Eigen::Index first, Eigen::Index last) {
        rows.middleRows(first, last - first) = columns.middleRows(first, last - first);
      },
      256);
}

}  // namespace thermotwin::solver
