/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/eigen.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#include "compensation/control/linear.h"

enum { most_sweeps = 60 };    /* of one eigenvalue */
enum { sorted_columns = 50 }; /* of a slice */
enum { phase_reduce, phase_form, phase_turn, phase_sort, phase_done, phase_failed };
enum { at_phase, at_column, at_sweeps }; /* of progress */

/* The parts of work. */
static double* off_diagonal(const tt_eigen* job) { return job->work; }         /* (n) e[i] couples i and i + 1 */
static double* factors(const tt_eigen* job) { return job->work + job->n; }     /* (n) of the reflections */
static double* scratch(const tt_eigen* job) { return job->work + 2 * job->n; } /* (n) */
static double* size(const tt_eigen* job) { return job->work + 3 * job->n; }    /* largest entry of A */
static double* column_of(const tt_eigen* job, ptrdiff_t j) { return job->a + j * job->n; }

int tt_eigen_work(int n) { return 3 * n + 1; }

int tt_eigen_slices(int n) { return 4 * n + n / sorted_columns + 30; }

void tt_eigen_begin(const tt_eigen* job) {
  const int n = job->n;
  double largest = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) largest = fabs(column_of(job, j)[i]) > largest ? fabs(column_of(job, j)[i]) : largest;
  }
  /* Squares of the entries then neither overflow nor vanish. */
  *size(job) = largest > 0.0 ? largest : 1.0;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) column_of(job, j)[i] /= *size(job);
  }
  job->progress[at_phase] = phase_reduce;
  job->progress[at_column] = 0;
  job->progress[at_sweeps] = 0;
}

/* A <- H A H with H = 1 - tau v v^T, which leaves of column k the diagonal and one entry below it. v(0) = 1; the rest
 * of v stands where the column's zeros are. Only the lower triangle is used. */
static void reduce_column(const tt_eigen* job, int k) {
  const int n = job->n, m = n - k - 1;
  double *x = column_of(job, k) + k + 1, *p = scratch(job);
  const double tail = tt_dot(m - 1, x + 1, x + 1);
  double tau = 0.0;
  off_diagonal(job)[k] = x[0];
  if (tail > 0.0) {
    const double length = sqrt(x[0] * x[0] + tail), beta = x[0] > 0.0 ? -length : length;
    tau = (beta - x[0]) / beta;
    tt_scale(m - 1, 1.0 / (x[0] - beta), x + 1);
    off_diagonal(job)[k] = beta;
    x[0] = 1.0;
    tt_zero(m, p);
    for (int j = 0; j < m; ++j) {
      const double* a = column_of(job, k + 1 + j) + k + 1;
      p[j] += a[j] * x[j] + tt_dot(m - j - 1, a + j + 1, x + j + 1);
      tt_axpy(m - j - 1, x[j], a + j + 1, p + j + 1);
    }
    tt_scale(m, tau, p);
    tt_axpy(m, -0.5 * tau * tt_dot(m, p, x), x, p);
    for (int j = 0; j < m; ++j) {
      double* a = column_of(job, k + 1 + j) + k + 1;
      const double xj = x[j], pj = p[j];
      for (int i = j; i < m; ++i) a[i] -= x[i] * pj + p[i] * xj;
    }
  }
  factors(job)[k] = tau;
  job->values[k] = column_of(job, k)[k];
}

/* Multiplies the orthogonal matrix of the columns behind k + 1 by the reflection of column k, in place. */
static void form_column(const tt_eigen* job, int k) {
  const int n = job->n, m = n - k - 2;
  const double *v = column_of(job, k) + k + 2, tau = factors(job)[k];
  for (int j = k + 2; j < n; ++j) {
    double* q = column_of(job, j) + k + 1;
    const double share = tau * tt_dot(m, v, q + 1);
    q[0] = -share;
    tt_axpy(m, -share, v, q + 1);
  }
  double* own = column_of(job, k + 1);
  tt_zero(k + 1, own);
  own[k + 1] = 1.0 - tau;
  for (int i = 0; i < m; ++i) own[k + 2 + i] = -tau * v[i];
}

static void rotate(int n, double c, double s, double* restrict first, double* restrict second) {
  for (int i = 0; i < n; ++i) {
    const double kept = second[i];
    second[i] = s * first[i] + c * kept;
    first[i] = c * first[i] - s * kept;
  }
}

/* End of the block that begins at l: the first entry of the off-diagonal that is nothing. */
static int block_end(const tt_eigen* job, int l) {
  const double *d = job->values, *e = off_diagonal(job);
  int m = l;
  for (; m < job->n - 1; ++m) {
    const double both = fabs(d[m]) + fabs(d[m + 1]);
    if (fabs(e[m]) <= DBL_EPSILON * both || fabs(e[m]) < DBL_MIN / DBL_EPSILON) break;
  }
  return m;
}

/* One sweep of QL on the rows l to m. */
static void sweep(const tt_eigen* job, int l, int m) {
  double *d = job->values, *e = off_diagonal(job);
  const double half = (d[l + 1] - d[l]) / (2.0 * e[l]), root = sqrt(half * half + 1.0);
  double g = d[m] - d[l] + e[l] / (half + (half < 0.0 ? -root : root));
  double s = 1.0, c = 1.0, shift = 0.0;
  for (int i = m - 1; i >= l; --i) {
    const double f = s * e[i], b = c * e[i], r = sqrt(f * f + g * g);
    e[i + 1] = r;
    if (!(r > 0.0)) { /* the block falls apart here */
      d[i + 1] -= shift;
      e[m] = 0.0;
      return;
    }
    s = f / r;
    c = g / r;
    g = d[i + 1] - shift;
    const double t = (d[i] - g) * s + 2.0 * c * b;
    shift = s * t;
    d[i + 1] = g + shift;
    g = c * t - b;
    rotate(job->n, c, s, column_of(job, i), column_of(job, i + 1));
  }
  d[l] -= shift;
  e[l] = g;
  e[m] = 0.0;
}

/* Sweeps of about n rotations together. */
static void turn(const tt_eigen* job) {
  const int n = job->n;
  int* l = &job->progress[at_column];
  int rotations = 0;
  while (*l < n) {
    const int m = block_end(job, *l);
    if (m == *l) {
      ++*l;
      job->progress[at_sweeps] = 0;
      continue;
    }
    if (rotations > 0 && rotations + m - *l > n) return;
    if (job->progress[at_sweeps]++ == most_sweeps) {
      job->progress[at_phase] = phase_failed;
      return;
    }
    sweep(job, *l, m);
    rotations += m - *l;
  }
  *l = 0;
  job->progress[at_phase] = phase_sort;
}

/* Some columns of the order; the values are those of A after the last. */
static void sort(const tt_eigen* job) {
  const int n = job->n, first = job->progress[at_column], last = first + sorted_columns;
  double* d = job->values;
  for (int i = first; i < last && i < n - 1; ++i) {
    int least = i;
    for (int j = i + 1; j < n; ++j) {
      if (d[j] < d[least]) least = j;
    }
    if (least == i) continue;
    const double kept = d[i];
    d[i] = d[least];
    d[least] = kept;
    double *upper = column_of(job, i), *lower = column_of(job, least);
    for (int r = 0; r < n; ++r) {
      const double entry = upper[r];
      upper[r] = lower[r];
      lower[r] = entry;
    }
  }
  job->progress[at_column] = last;
  if (last < n) return;
  tt_scale(n, *size(job), d);
  job->progress[at_phase] = phase_done;
}

static void reduce(const tt_eigen* job) {
  const int n = job->n;
  int* k = &job->progress[at_column];
  if (*k < n - 2) {
    reduce_column(job, (*k)++);
    return;
  }
  /* The last two columns are tridiagonal as they are. */
  for (int j = n < 2 ? 0 : n - 2; j < n; ++j) job->values[j] = column_of(job, j)[j];
  if (n > 1) off_diagonal(job)[n - 2] = column_of(job, n - 2)[n - 1];
  off_diagonal(job)[n - 1] = 0.0;
  tt_zero(n, column_of(job, n - 1));
  column_of(job, n - 1)[n - 1] = 1.0;
  if (n > 1) factors(job)[n - 2] = 0.0;
  *k = n - 3;
  job->progress[at_phase] = phase_form;
}

static void form(const tt_eigen* job) {
  const int n = job->n;
  int* k = &job->progress[at_column];
  if (*k >= 0) {
    form_column(job, (*k)--);
    return;
  }
  if (n > 1) {
    tt_zero(n, column_of(job, 0));
    column_of(job, 0)[0] = 1.0;
    for (int j = 1; j < n; ++j) column_of(job, j)[0] = 0.0;
  }
  *k = 0;
  job->progress[at_phase] = phase_turn;
}

int tt_eigen_slice(const tt_eigen* job) {
  int* phase = &job->progress[at_phase];
  switch (*phase) {
    case phase_reduce: reduce(job); break;
    case phase_form: form(job); break;
    case phase_turn: turn(job); break;
    case phase_sort: sort(job); break;
    default: break;
  }
  return *phase == phase_done ? 1 : *phase == phase_failed ? 2 : 0;
}

int tt_symmetric_eigen(int n, double* a, double* values, double* work) {
  int32_t progress[tt_eigen_progress];
  const tt_eigen job = {n, a, values, work, progress};
  int state = 0;
  tt_eigen_begin(&job);
  while (state == 0) state = tt_eigen_slice(&job);
  return state == 1 ? 0 : 1;
}
