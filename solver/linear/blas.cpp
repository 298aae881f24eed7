// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/blas.h"

#include <algorithm>
#include <dlfcn.h>
#include <mutex>
#include <shared_mutex>
#include <thread>

#include "core/blas_buffers.h"

extern "C" {
void dgemm_(const char* a_op, const char* b_op, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* a_stride, const double* b, const int* b_stride, const double* beta, double* c,
            const int* c_stride);
void dtrsm_(const char* side, const char* triangle, const char* op, const char* diagonal, const int* m, const int* n,
            const double* alpha, const double* a, const int* a_stride, double* b, const int* b_stride);
}

namespace thermotwin::solver {

namespace {

std::shared_mutex& turn_mutex() {
  static std::shared_mutex instance;
  return instance;
}

void set_threads(int threads) {
  using Setter = void (*)(int);
  static const auto setter = reinterpret_cast<Setter>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (setter) setter(std::max(1, threads));
}

constexpr double one = 1.0, minus_one = -1.0;

}  // namespace

BlasTurn::BlasTurn(bool many_cores) : many_cores_(many_cores) {
  core::reserve_blas_buffers();
  if (many_cores) {
    turn_mutex().lock();
    set_threads(std::thread::hardware_concurrency());
  } else {
    static std::once_flag once;
    std::call_once(once, [] { set_threads(1); });
    turn_mutex().lock_shared();
  }
}

BlasTurn::~BlasTurn() {
  if (many_cores_) {
    set_threads(1);
    turn_mutex().unlock();
  } else {
    turn_mutex().unlock_shared();
  }
}

// To the BLAS a block that lies row by row is its transpose, (width x rows).

void blas_subtract(const double* a, std::int64_t stride, std::int64_t rows, std::int64_t columns, const double* y,
                   double* out, std::int64_t width) {
  const int m = width, n = rows, k = columns, ld = stride;
  dgemm_("N", "T", &m, &n, &k, &minus_one, y, &m, a, &ld, &one, out, &m);
}

void blas_subtract_transposed(const double* a, std::int64_t stride, std::int64_t rows, std::int64_t columns,
                              const double* x, double* out, std::int64_t width) {
  const int m = width, n = columns, k = rows, ld = stride;
  dgemm_("N", "N", &m, &n, &k, &minus_one, x, &m, a, &ld, &one, out, &m);
}

void blas_solve_lower(const double* l, std::int64_t stride, std::int64_t columns, double* y, std::int64_t width,
                      bool transposed) {
  const int m = width, n = columns, ld = stride;
  dtrsm_("R", "L", transposed ? "N" : "T", "N", &m, &n, &one, l, &ld, y, &m);
}

}  // namespace thermotwin::solver
