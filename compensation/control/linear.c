/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/linear.h"

#include <math.h>

double tt_dot(ptrdiff_t n, const double* a, const double* b) {
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
  ptrdiff_t i = 0;
  for (; i + 4 <= n; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  for (; i < n; ++i) s0 += a[i] * b[i];
  return (s0 + s1) + (s2 + s3);
}

double tt_norm(ptrdiff_t n, const double* a) { return sqrt(tt_dot(n, a, a)); }

void tt_zero(ptrdiff_t n, double* y) {
  for (ptrdiff_t i = 0; i < n; ++i) y[i] = 0.0;
}

void tt_copy(ptrdiff_t n, const double* x, double* y) {
  for (ptrdiff_t i = 0; i < n; ++i) y[i] = x[i];
}

void tt_scale(ptrdiff_t n, double factor, double* y) {
  for (ptrdiff_t i = 0; i < n; ++i) y[i] *= factor;
}

void tt_axpy(ptrdiff_t n, double factor, const double* restrict x, double* restrict y) {
  for (ptrdiff_t i = 0; i < n; ++i) y[i] += factor * x[i];
}

void tt_gemv(ptrdiff_t rows, ptrdiff_t cols, double factor, const double* restrict a, const double* restrict x,
             double* restrict y) {
  ptrdiff_t j = 0;
  /* Four columns a pass: y is read and written once for them. */
  for (; j + 4 <= cols; j += 4) {
    const double *a0 = a + j * rows, *a1 = a0 + rows, *a2 = a1 + rows, *a3 = a2 + rows;
    const double x0 = factor * x[j], x1 = factor * x[j + 1], x2 = factor * x[j + 2], x3 = factor * x[j + 3];
    for (ptrdiff_t i = 0; i < rows; ++i) y[i] += (a0[i] * x0 + a1[i] * x1) + (a2[i] * x2 + a3[i] * x3);
  }
  for (; j < cols; ++j) tt_axpy(rows, factor * x[j], a + j * rows, y);
}

void tt_gemv_t(ptrdiff_t rows, ptrdiff_t cols, double factor, const double* restrict a, const double* restrict x,
               double* restrict y) {
  for (ptrdiff_t j = 0; j < cols; ++j) y[j] += factor * tt_dot(rows, a + j * rows, x);
}

void tt_gemm(ptrdiff_t rows, ptrdiff_t cols, ptrdiff_t inner, double factor, const double* a, const double* b,
             double* c) {
  for (ptrdiff_t j = 0; j < cols; ++j) tt_gemv(rows, inner, factor, a, b + j * inner, c + j * rows);
}

void tt_gemm_tn(ptrdiff_t rows, ptrdiff_t cols, ptrdiff_t inner, double factor, const double* a, const double* b,
                double* c) {
  for (ptrdiff_t j = 0; j < cols; ++j) tt_gemv_t(inner, rows, factor, a, b + j * inner, c + j * rows);
}

int tt_cholesky_columns(ptrdiff_t n, double* a, int first, int last) {
  for (int j = first; j < last; ++j) {
    double* column = a + j * n;
    for (ptrdiff_t k = 0; k < j; ++k) {
      const double* before = a + k * n;
      tt_axpy(n - j, -before[j], before + j, column + j);
    }
    if (!(column[j] > 0.0)) return 1 + j;
    const double pivot = sqrt(column[j]);
    column[j] = pivot;
    for (ptrdiff_t i = j + 1; i < n; ++i) column[i] /= pivot;
  }
  return 0;
}

void tt_cholesky_solve(ptrdiff_t n, const double* factor, double* x) {
  for (ptrdiff_t j = 0; j < n; ++j) {
    const double* column = factor + j * n;
    x[j] /= column[j];
    tt_axpy(n - j - 1, -x[j], column + j + 1, x + j + 1);
  }
  for (ptrdiff_t j = n - 1; j >= 0; --j) {
    const double* column = factor + j * n;
    x[j] = (x[j] - tt_dot(n - j - 1, column + j + 1, x + j + 1)) / column[j];
  }
}

static void exchange(double* a, double* b) {
  const double kept = *a;
  *a = *b;
  *b = kept;
}

static void exchange_rows(const int32_t* pivots, ptrdiff_t first, ptrdiff_t last, double* column) {
  for (ptrdiff_t k = first; k < last; ++k) exchange(column + k, column + pivots[k]);
}
/* What column k of the factor takes from a column, in place: by its lower part, and by its upper one. */
static void eliminate(ptrdiff_t n, const double* a, ptrdiff_t k, double* column) {
  tt_axpy(n - k - 1, -column[k], a + k * n + k + 1, column + k + 1);
}
static void substitute(ptrdiff_t n, const double* a, ptrdiff_t k, double* column) {
  column[k] /= a[k + k * n];
  tt_axpy(k, -column[k], a + k * n, column);
}

int tt_lu_columns(ptrdiff_t n, double* a, int32_t* pivots, int first, int last) {
  for (ptrdiff_t j = first; j < last; ++j) exchange_rows(pivots, 0, first, a + j * n);
  /* Each column of the factor before is read once for all of these. */
  for (ptrdiff_t k = 0; k < first; ++k) {
    for (ptrdiff_t j = first; j < last; ++j) eliminate(n, a, k, a + j * n);
  }
  for (int j = first; j < last; ++j) {
    double* column = a + j * n;
    exchange_rows(pivots, first, j, column);
    for (ptrdiff_t k = first; k < j; ++k) eliminate(n, a, k, column);
    int pivot = j;
    for (int i = j + 1; i < n; ++i) {
      if (fabs(column[i]) > fabs(column[pivot])) pivot = i;
    }
    pivots[j] = pivot;
    if (!(fabs(column[pivot]) > 0.0)) return 1 + j;
    if (pivot != j) {
      /* The columns before keep their rows exchanged as well: L is that of the exchanged matrix. */
      for (ptrdiff_t k = 0; k <= j; ++k) exchange(a + k * n + j, a + k * n + pivot);
    }
    for (ptrdiff_t i = j + 1; i < n; ++i) column[i] /= column[j];
  }
  return 0;
}

void tt_lu_exchange(ptrdiff_t n, const int32_t* pivots, double* x) { exchange_rows(pivots, 0, n, x); }

void tt_lu_eliminate(ptrdiff_t n, const double* factor, ptrdiff_t first, ptrdiff_t last, double* x) {
  for (ptrdiff_t j = first; j < last; ++j) eliminate(n, factor, j, x);
}

void tt_lu_substitute(ptrdiff_t n, const double* factor, ptrdiff_t first, ptrdiff_t last, double* x) {
  for (ptrdiff_t j = last - 1; j >= first; --j) substitute(n, factor, j, x);
}

void tt_lu_solve(ptrdiff_t n, const double* factor, const int32_t* pivots, double* x) {
  tt_lu_exchange(n, pivots, x);
  tt_lu_eliminate(n, factor, 0, n, x);
  tt_lu_substitute(n, factor, 0, n, x);
}
