// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The BLAS's threads, and two of its operations on blocks whose right-hand sides lie side by side.

#include <cstdint>

namespace thermotwin::solver {

/// Threads of the BLAS at hand while this lives. OpenBLAS is told through its own call where it is the
/// BLAS in use; the reference BLAS and ATLAS have one thread anyway. Who needs many cores has the BLAS
/// alone; the others must not wait for work of the pool meanwhile.
class BlasTurn {
public:
  explicit BlasTurn(bool many_cores = false);
  ~BlasTurn();
  BlasTurn(const BlasTurn&) = delete;
  BlasTurn& operator=(const BlasTurn&) = delete;

private:
  bool many_cores_;
};

/// out (rows x width) -= A y, A (rows x columns) column-major with the stride, y and out row by row.
void blas_subtract(const double* a, std::int64_t stride, std::int64_t rows, std::int64_t columns, const double* y,
                   double* out, std::int64_t width);
/// out (columns x width) -= A^T x
void blas_subtract_transposed(const double* a, std::int64_t stride, std::int64_t rows, std::int64_t columns,
                              const double* x, double* out, std::int64_t width);
/// In place: the lower triangle L of columns, or its transpose, into y (columns x width).
void blas_solve_lower(const double* l, std::int64_t stride, std::int64_t columns, double* y, std::int64_t width,
                      bool transposed);

}  // namespace thermotwin::solver
