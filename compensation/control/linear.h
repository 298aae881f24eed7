/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_LINEAR_H
#define THERMOTWIN_LINEAR_H
/* Dense linear algebra of the online core. Matrices are column-major without gaps: a(i, j) = a[i + j * rows]. Sums run
 * in an order that the source fixes (four partial sums in tt_dot), so that compilers and processors give the same bits
 * as long as they do not contract a product and a sum (-ffp-contract=off). Nothing allocates. Arguments that are
 * written must not overlap those that are read. Sizes are ptrdiff_t: products of them are places in a matrix. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

double tt_dot(ptrdiff_t n, const double* a, const double* b);
double tt_norm(ptrdiff_t n, const double* a);
void tt_zero(ptrdiff_t n, double* y);
void tt_copy(ptrdiff_t n, const double* x, double* y);
void tt_scale(ptrdiff_t n, double factor, double* y);
void tt_axpy(ptrdiff_t n, double factor, const double* x, double* y); /* y += factor x */

/* y += factor A x,   A (rows x cols) */
void tt_gemv(ptrdiff_t rows, ptrdiff_t cols, double factor, const double* a, const double* x, double* y);
/* y += factor A^T x,   A (rows x cols), y (cols) */
void tt_gemv_t(ptrdiff_t rows, ptrdiff_t cols, double factor, const double* a, const double* x, double* y);
/* C += factor A B,   A (rows x inner), B (inner x cols) */
void tt_gemm(ptrdiff_t rows, ptrdiff_t cols, ptrdiff_t inner, double factor, const double* a, const double* b,
             double* c);
/* C += factor A^T B,   A (inner x rows), B (inner x cols) */
void tt_gemm_tn(ptrdiff_t rows, ptrdiff_t cols, ptrdiff_t inner, double factor, const double* a, const double* b,
                double* c);

/* Columns [first, last) of the factor L of a symmetric positive definite matrix A = L L^T, in place of its lower
 * triangle; the columns before must be there. The upper triangle is not used.
 * Returns 0, or 1 + the column of a pivot that is not positive. */
int tt_cholesky_columns(ptrdiff_t n, double* a, int first, int last);
/* x <- L^-T L^-1 x */
void tt_cholesky_solve(ptrdiff_t n, const double* factor, double* x);

/* Columns [first, last) of an LU factorisation with row exchanges, in place (left-looking); pivots[j] is the row that
 * column j exchanged. Returns 0, or 1 + the column of a pivot that is zero. */
int tt_lu_columns(ptrdiff_t n, double* a, int32_t* pivots, int first, int last);
/* x <- A^-1 x. Its three parts, the last two by columns [first, last) of the factor: exchange, elimination by rising
 * columns, substitution by falling ones. */
void tt_lu_solve(ptrdiff_t n, const double* factor, const int32_t* pivots, double* x);
void tt_lu_exchange(ptrdiff_t n, const int32_t* pivots, double* x);
void tt_lu_eliminate(ptrdiff_t n, const double* factor, ptrdiff_t first, ptrdiff_t last, double* x);
void tt_lu_substitute(ptrdiff_t n, const double* factor, ptrdiff_t first, ptrdiff_t last, double* x);

#ifdef __cplusplus
}
#endif
#endif
