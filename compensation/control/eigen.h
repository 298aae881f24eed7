/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_EIGEN_H
#define THERMOTWIN_EIGEN_H
/* Eigenvalues (rising) and orthonormal vectors of a symmetric matrix, A = Z D Z^T: Householder tridiagonalisation, then
 * implicit QL with Wilkinson's shift (Golub and Van Loan, Matrix Computations, 8.3). The work is cut into slices of
 * about n^2 multiplications. QL needs no vectors, so that a slice turns some rows of them by all rotations of some
 * sweeps, and reads few. Values are accurate to some epsilon of the largest, whatever their size. */

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A job whose values, progress included, lie in arrays of the caller. */
typedef struct tt_eigen {
  int n;
  double* a;         /* (n x n) at least the lower triangle before tt_eigen_begin; the vectors after */
  double* values;    /* (n) */
  double* work;      /* (tt_eigen_work(n)) */
  int32_t* progress; /* (tt_eigen_progress) */
} tt_eigen;

enum { tt_eigen_progress = 7 };
int tt_eigen_work(int n);
/* Number of slices to plan for: three columns in two, and QL at two and a half sweeps an eigenvalue on average. */
int tt_eigen_slices(int n);

void tt_eigen_begin(const tt_eigen* job);
/* Returns 0: more to do, 1: done, 2: an eigenvalue did not converge in 60 sweeps. */
int tt_eigen_slice(const tt_eigen* job);

/* All slices at once. work: tt_eigen_work(n) doubles. Returns 0, or 1 without convergence. */
int tt_symmetric_eigen(int n, double* a, double* values, double* work);

#ifdef __cplusplus
}
#endif
#endif
