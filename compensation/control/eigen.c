/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/eigen.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#include "compensation/control/linear.h"

enum { most_sweeps = 60 };    /* of one eigenvalue */
enum { sorted_columns = 50 }; /* of a slice */
enum { rotation_values = 4 }; /* of the sweep under way */
enum { phase_measure, phase_scale, phase_reduce, phase_form, phase_turn, phase_sort, phase_done, phase_failed };
/* Of progress. Within a column: the part of its reflection, or the next column to multiply. A sweep that is under way
 * has its next row and its end; rotations that wait have their count and the next row to turn. */
enum { at_phase, at_column, at_sweeps, at_part, at_end, at_count, at_row };
enum { waiting_sweeps = 3 };
enum { panels = 3 * waiting_sweeps - 1 }; /* with the slice that finds the rotations: n / 3 of them each */

/* The parts of work. */
static double* off_diagonal(const tt_eigen* job) { return job->work; }         /* (n) e[i] couples i and i + 1 */
static double* factors(const tt_eigen* job) { return job->work + job->n; }     /* (n) of the reflections */
static double* scratch(const tt_eigen* job) { return job->work + 2 * job->n; } /* (n) */
static double* size(const tt_eigen* job) { return job->work + 3 * job->n; }    /* largest entry of A */
/* Column, cosine, sine of each. */
static double* waiting(const tt_eigen* job) { return size(job) + 1 + rotation_values; }
static int most_waiting(const tt_eigen* job) { return waiting_sweeps * job->n; }
static double* column_of(const tt_eigen* job, ptrdiff_t j) { return job->a + j * job->n; }

/* Of the sweep under way. */
typedef struct rotation {
  double g, s, c, shift;
} rotation;

static rotation kept_rotation(const tt_eigen* job) {
  const double* kept = size(job) + 1;
  const rotation own = {kept[0], kept[1], kept[2], kept[3]};
  return own;
}

static void keep_rotation(const tt_eigen* job, rotation own) {
  double* kept = size(job) + 1;
  kept[0] = own.g;
  kept[1] = own.s;
  kept[2] = own.c;
  kept[3] = own.shift;
}

/* Multiplications of a slice, about, and of a part of a reflection of m rows. */
static ptrdiff_t products(ptrdiff_t m) { return m * m; }
static ptrdiff_t slice_products(int n) { return products(n); }

int tt_eigen_work(int n) { return 3 * n + 1 + rotation_values + 3 * waiting_sweeps * n; }

int tt_eigen_slices(int n) { return 11 * n / 2 + n / sorted_columns + 30 + panels; }

void tt_eigen_begin(const tt_eigen* job) {
  for (int i = 0; i < tt_eigen_progress; ++i) job->progress[i] = 0;
  job->progress[at_phase] = phase_measure;
}

/* Squares of scaled entries neither overflow nor vanish. */
static void measure(const tt_eigen* job) {
  const int n = job->n;
  double largest = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) largest = fabs(column_of(job, j)[i]) > largest ? fabs(column_of(job, j)[i]) : largest;
  }
  *size(job) = largest > 0.0 ? largest : 1.0;
  job->progress[at_phase] = phase_scale;
}

static void scale(const tt_eigen* job) {
  const int n = job->n;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) column_of(job, j)[i] /= *size(job);
  }
  job->progress[at_phase] = phase_reduce;
}

/* A <- H A H with H = 1 - tau v v^T, which leaves of column k the diagonal and one entry below it. v(0) = 1; the rest
 * of v stands where the column's zeros are. Only the lower triangle is used. First part: v, tau and A v. */
static void reflect(const tt_eigen* job, int k) {
  const int m = job->n - k - 1;
  double *x = column_of(job, k) + k + 1, *p = scratch(job);
  const double tail = tt_dot(m - 1, x + 1, x + 1);
  off_diagonal(job)[k] = x[0];
  factors(job)[k] = 0.0;
  if (!(tail > 0.0)) return;
  const double length = sqrt(x[0] * x[0] + tail), beta = x[0] > 0.0 ? -length : length, tau = (beta - x[0]) / beta;
  factors(job)[k] = tau;
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
}

/* Second part: the columns behind k. */
static void reduce_rest(const tt_eigen* job, int k) {
  const int m = job->n - k - 1;
  const double *x = column_of(job, k) + k + 1, *p = scratch(job);
  for (int j = 0; j < m && factors(job)[k] != 0.0; ++j) {
    double* a = column_of(job, k + 1 + j) + k + 1;
    const double xj = x[j], pj = p[j];
    for (int i = j; i < m; ++i) a[i] -= x[i] * pj + p[i] * xj;
  }
  job->values[k] = column_of(job, k)[k];
}

/* Multiplies a column of the orthogonal matrix of the columns behind k + 1 by the reflection of column k, in place. */
static void form_part(const tt_eigen* job, int k, int j) {
  const int m = job->n - k - 2;
  const double *v = column_of(job, k) + k + 2, tau = factors(job)[k];
  double* q = column_of(job, j) + k + 1;
  const double share = tau * tt_dot(m, v, q + 1);
  q[0] = -share;
  tt_axpy(m, -share, v, q + 1);
}

/* The column that the reflection of column k adds. */
static void form_own(const tt_eigen* job, int k) {
  const int m = job->n - k - 2;
  const double *v = column_of(job, k) + k + 2, tau = factors(job)[k];
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

/* A sweep of QL on the rows l to m begins at its end. */
static void begin_sweep(const tt_eigen* job, int l, int m) {
  const double *d = job->values, *e = off_diagonal(job);
  const double half = (d[l + 1] - d[l]) / (2.0 * e[l]), root = sqrt(half * half + 1.0);
  const rotation first = {d[m] - d[l] + e[l] / (half + (half < 0.0 ? -root : root)), 1.0, 1.0, 0.0};
  keep_rotation(job, first);
  job->progress[at_part] = m - 1;
  job->progress[at_end] = m;
}

static void end_sweep(const tt_eigen* job) { job->progress[at_end] = 0; }

static void wait(const tt_eigen* job, int column, double c, double s) {
  double* own = waiting(job) + 3 * job->progress[at_count]++;
  own[0] = column;
  own[1] = c;
  own[2] = s;
}

/* Rotations of the sweep, until no more can wait. */
static void sweep_on(const tt_eigen* job) {
  double *d = job->values, *e = off_diagonal(job);
  const int l = job->progress[at_column], m = job->progress[at_end];
  int* i = &job->progress[at_part];
  rotation w = kept_rotation(job);
  for (; *i >= l && job->progress[at_count] < most_waiting(job); --*i) {
    const double f = w.s * e[*i], b = w.c * e[*i], r = sqrt(f * f + w.g * w.g);
    e[*i + 1] = r;
    if (!(r > 0.0)) { /* the block falls apart here */
      d[*i + 1] -= w.shift;
      e[m] = 0.0;
      end_sweep(job);
      return;
    }
    w.s = f / r;
    w.c = w.g / r;
    w.g = d[*i + 1] - w.shift;
    const double t = (d[*i] - w.g) * w.s + 2.0 * w.c * b;
    w.shift = w.s * t;
    d[*i + 1] = w.g + w.shift;
    w.g = w.c * t - b;
    wait(job, *i, w.c, w.s);
  }
  keep_rotation(job, w);
  if (*i >= l) return;
  d[l] -= w.shift;
  e[l] = w.g;
  e[m] = 0.0;
  end_sweep(job);
}

/* Finds rotations until no more can wait, or all values are known. */
static void find_rotations(const tt_eigen* job) {
  const int n = job->n;
  int* l = &job->progress[at_column];
  while (*l < n) {
    if (job->progress[at_end] == 0) {
      const int m = block_end(job, *l);
      if (m == *l) {
        ++*l;
        job->progress[at_sweeps] = 0;
        continue;
      }
      if (job->progress[at_count] == most_waiting(job)) return;
      if (job->progress[at_sweeps]++ == most_sweeps) {
        job->progress[at_phase] = phase_failed;
        return;
      }
      begin_sweep(job, *l, m);
    }
    sweep_on(job);
    if (job->progress[at_end] != 0) return;
  }
}

/* The rotations that wait, or some rows of the vectors turned by them. */
static void turn(const tt_eigen* job) {
  const int n = job->n, count = job->progress[at_count];
  int* row = &job->progress[at_row];
  if (count == 0) {
    find_rotations(job);
    *row = 0;
  } else {
    const int all = (n / panels / 8 + 1) * 8, rows = all < n - *row ? all : n - *row; /* whole vectors of a processor */
    for (int k = 0; k < count; ++k) {
      const double* own = waiting(job) + 3 * k;
      double* column = column_of(job, (ptrdiff_t)own[0]) + *row;
      rotate(rows, own[1], own[2], column, column + n);
    }
    *row += rows;
    if (*row == n) job->progress[at_count] = 0;
  }
  if (job->progress[at_count] > 0 || job->progress[at_column] < n || job->progress[at_phase] != phase_turn) return;
  job->progress[at_column] = 0;
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

/* The last two columns are tridiagonal as they are. */
static void end_reduction(const tt_eigen* job) {
  const int n = job->n;
  for (int j = n < 2 ? 0 : n - 2; j < n; ++j) job->values[j] = column_of(job, j)[j];
  if (n > 1) off_diagonal(job)[n - 2] = column_of(job, n - 2)[n - 1];
  off_diagonal(job)[n - 1] = 0.0;
  tt_zero(n, column_of(job, n - 1));
  column_of(job, n - 1)[n - 1] = 1.0;
  if (n > 1) factors(job)[n - 2] = 0.0;
  job->progress[at_column] = n - 3;
  job->progress[at_part] = n - 1;
  job->progress[at_phase] = phase_form;
}

static void reduce(const tt_eigen* job) {
  const int n = job->n;
  int *k = &job->progress[at_column], *part = &job->progress[at_part];
  for (ptrdiff_t done = 0; *k < n - 2;) {
    const ptrdiff_t more = products(n - *k - 1);
    if (done > 0 && done + more > slice_products(n)) return;
    done += more;
    if (*part == 0)
      reflect(job, *k);
    else
      reduce_rest(job, (*k)++);
    *part = 1 - *part;
  }
  end_reduction(job);
}

static void form(const tt_eigen* job) {
  const int n = job->n;
  int *k = &job->progress[at_column], *j = &job->progress[at_part];
  for (ptrdiff_t left = slice_products(n); *k >= 0;) {
    for (; *j < n; ++*j) {
      if (left < 0) return;
      form_part(job, *k, *j);
      left -= 2 * (n - *k);
    }
    form_own(job, (*k)--);
    *j = *k + 2;
  }
  if (n > 1) {
    tt_zero(n, column_of(job, 0));
    column_of(job, 0)[0] = 1.0;
    for (int i = 1; i < n; ++i) column_of(job, i)[0] = 0.0;
  }
  job->progress[at_column] = 0;
  job->progress[at_end] = 0;
  job->progress[at_phase] = phase_turn;
}

int tt_eigen_slice(const tt_eigen* job) {
  int* phase = &job->progress[at_phase];
  switch (*phase) {
    case phase_measure: measure(job); break;
    case phase_scale: scale(job); break;
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
