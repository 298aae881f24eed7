// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// L L^T y = b with the values of a supernodal Cholesky factor made elsewhere, for right-hand sides that
// lie side by side (node-major): the factor passes through memory twice, whatever their number. Up to
// twelve are worked on in registers, more by the BLAS. Disjoint subtrees of the elimination tree are
// worked on at the same time, each with places of its own for what it takes from rows above it, which
// are added in a fixed order; in the large supernodes at the top, blocks of rows (columns on the way
// back) are. The division does not know the number of threads, so that results are the same bits for any.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace thermotwin::solver {

/// Supernode s: columns column[s] .. column[s + 1] - 1; its rows, ascending, its own columns first,
/// are row[row_begin[s]] .. ; its values, column-major with all these rows, begin at value_begin[s],
/// the upper triangle unused. Supernodes are in postorder.
struct SupernodalPattern {
  std::vector<std::int64_t> column, row_begin, value_begin;  ///< (supernodes + 1)
  std::vector<int> row;
};

class SupernodalSweeps {
public:
  static constexpr int few_columns = 12, most_columns = 64;

  explicit SupernodalSweeps(SupernodalPattern pattern);

  std::int64_t size() const { return pattern_.column.back(); }
  std::int64_t values() const { return pattern_.value_begin.back(); }
  /// Columns that a block of so many right-hand sides (at most most_columns) is padded to.
  static int width_for(std::int64_t columns) { return columns <= 1 ? 1 : (columns + 3) / 4 * 4; }
  /// Rows of the working block: size() and the subtrees' places.
  std::int64_t work_rows() const { return work_rows_; }

  /// In place. @param values  of the factor   @param y  (work_rows x width) row by row; what is
  /// beyond size() is overwritten   @param width  by width_for
  /// @param backward_only  L^T y = b instead
  void solve(const double* values, double* y, int width, bool backward_only = false) const;
  /// Values rounded to single precision, half of what passes through memory; sums are double.
  /// @param width  at most few_columns
  void solve(const float* values, double* y, int width) const;
  double memory_bytes() const;

private:
  struct Subtree {
    std::int64_t first, last, extra_begin, root;
  };  ///< supernodes [first, last]

  template <class Kernel, class Value>
  void run(Kernel kernel, const Value* values, double* y, bool backward_only) const;
  template <class Kernel, class Value>
  void forward(Kernel kernel, std::int64_t s, const Value* values, double* y, bool split) const;
  template <class Kernel, class Value>
  void backward(Kernel kernel, std::int64_t s, const Value* values, double* y, bool split) const;
  void plan();

  SupernodalPattern pattern_;
  std::vector<int> target_;  ///< as row, with places of subtrees for rows above them
  std::vector<Subtree> subtrees_;
  std::vector<std::int64_t> top_;  ///< supernodes in no subtree, rising
  std::int64_t work_rows_ = 0;
};

}  // namespace thermotwin::solver
